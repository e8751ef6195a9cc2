// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The 3D view of report.html: thinned cloud, trajectories and relative poses, turned with the mouse
// or by touch. Its data are JSON in <script id="scene">, written by report_3d.cpp:
//   points   count; positions: base64 of uint16 x y z each, little endian, low + step * value
//   colours  base64 of uint8 r g b each
//   uavs     [{name, colour, paths: [[x y z …], …]}]; links: [x y z x y z …]
//   middle, reach, heights, top  of the cloud, of most of its heights, of the highest camera
// Metres, relative to one place; z is up.
import {
  BufferAttribute, BufferGeometry, Color, Float32BufferAttribute, Line, LineBasicMaterial,
  LineSegments, PerspectiveCamera, Points, PointsMaterial, Scene, Vector3, WebGLRenderer
} from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';

const BACKGROUND = 0xf3f4f6;

function bytesOf(base64) {
  const text = atob(base64), bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return bytes;
}

// Blue over green and yellow to red, as the height picture has it.
function heightColour(share, out, at) {
  const stops = [[49, 54, 149], [116, 173, 209], [171, 221, 164], [254, 224, 139], [215, 48, 39]];
  const x = Math.min(Math.max(share, 0), 1) * (stops.length - 1), i = Math.min(Math.floor(x), 3);
  for (let k = 0; k < 3; ++k) out[at + k] = stops[i][k] + (x - i) * (stops[i + 1][k] - stops[i][k]);
}

function cloudOf(data) {
  const bytes = bytesOf(data.positions), values = new DataView(bytes.buffer);
  const position = new Float32Array(3 * data.points), height = new Uint8Array(3 * data.points);
  for (let i = 0; i < position.length; ++i)
    position[i] = data.low[i % 3] + data.step * values.getUint16(2 * i, true);
  for (let i = 0; i < data.points; ++i)
    heightColour((position[3 * i + 2] - data.heights[0]) / (data.heights[1] - data.heights[0]),
                 height, 3 * i);
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(position, 3));
  const natural = new BufferAttribute(bytesOf(data.colours), 3, true);
  geometry.setAttribute('color', natural);
  const material = new PointsMaterial({ size: data.size, vertexColors: true });
  return { points: new Points(geometry, material), natural, byHeight: new BufferAttribute(height, 3, true) };
}

function lineGeometry(numbers) {
  return new BufferGeometry().setAttribute('position', new Float32BufferAttribute(numbers, 3));
}

function start(box, data) {
  const renderer = new WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
  renderer.outputColorSpace = 'srgb-linear';  // colours are shown as they are stored
  renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
  box.prepend(renderer.domElement);
  const scene = new Scene();
  scene.background = new Color().setHex(BACKGROUND, 'srgb-linear');

  const cloud = cloudOf(data);
  scene.add(cloud.points);
  const tracks = [];
  for (const uav of data.uavs) {
    const color = new Color().setStyle(uav.colour, 'srgb-linear');
    for (const path of uav.paths) {
      tracks.push(new Line(lineGeometry(path), new LineBasicMaterial({ color })));
      tracks.push(new Points(lineGeometry(path),
                             new PointsMaterial({ color, size: 5, sizeAttenuation: false })));
    }
  }
  const links = new LineSegments(
      lineGeometry(data.links), new LineBasicMaterial({ color: new Color(1, 0, 0) }));
  for (const item of [...tracks, links]) scene.add(item);

  const camera = new PerspectiveCamera(40, 1, data.reach / 1000, data.reach * 20);
  camera.up.set(0, 0, 1);
  const controls = new OrbitControls(camera, renderer.domElement);
  controls.maxPolarAngle = Math.PI / 2;
  const middle = new Vector3(...data.middle);
  const draw = () => renderer.render(scene, camera);
  const look = (direction) => {
    const portrait = Math.max(1, box.clientHeight / box.clientWidth);
    controls.target.copy(middle).setZ(middle.z + 0.35 * (data.top - middle.z));
    camera.position.copy(controls.target).addScaledVector(direction.normalize(), 1.25 * Math.max(2.1 * data.reach, 1.6 * (data.top - middle.z)) * portrait);
    controls.update();
    draw();
  };
  const resize = () => {
    renderer.setSize(box.clientWidth, box.clientHeight);
    camera.aspect = box.clientWidth / box.clientHeight;
    camera.updateProjectionMatrix();
    draw();
  };
  controls.addEventListener('change', draw);
  window.addEventListener('resize', resize);

  const on = (name, event, act) => {
    const item = document.getElementById('view-' + name);
    if (item) item.addEventListener(event, () => { act(item); draw(); });
  };
  on('height', 'change', (box) => cloud.points.geometry.setAttribute(
      'color', box.checked ? cloud.byHeight : cloud.natural));
  on('tracks', 'change', (box) => tracks.forEach((item) => { item.visible = box.checked; }));
  on('links', 'change', (box) => { links.visible = box.checked; });
  on('size', 'input', (range) => { cloud.points.material.size = data.size * Math.pow(2, range.value); });
  on('above', 'click', () => look(new Vector3(0, -0.001, 1)));
  on('aslant', 'click', () => look(new Vector3(-0.45, -1, 0.8)));

  resize();
  look(new Vector3(-0.45, -1, 0.8));
  // Says for tests, and for those who ask why the view is empty, what share of it is drawn.
  const gl = renderer.getContext(), w = gl.drawingBufferWidth, h = gl.drawingBufferHeight;
  const pixels = new Uint8Array(4 * w * h);
  gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  let drawn = 0;
  for (let i = 0; i < pixels.length; i += 4)
    if (pixels[i] !== 0xf3 || pixels[i + 1] !== 0xf4 || pixels[i + 2] !== 0xf6) ++drawn;
  box.dataset.drawn = (drawn / (w * h)).toFixed(4);
}

const box = document.getElementById('view');
try {
  start(box, JSON.parse(document.getElementById('scene').textContent));
} catch (error) {
  box.classList.add('dead');
  box.textContent = 'This browser cannot draw in 3D (WebGL): ' + error.message;
}
