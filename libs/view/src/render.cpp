// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/view/render.h"

#include <fmt/format.h>
#include <mrpt/opengl/COpenGLScene.h>

#include <algorithm>
#include <cmath>
#include <future>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "cf/base/disk.h"
#include "cf/base/error.h"
#include "cf/base/log.h"
#include "cf/formats/atomic_file.h"
#include "compose.h"
#include "offscreen.h"
#include "overlay.h"
#include "scene_objects.h"
#include "visible_points.h"

namespace cf {
namespace {

namespace fs = std::filesystem;
using mrpt::opengl::COpenGLScene;

constexpr int kSupersampling = 2;                // each pixel is the mean of 2 x 2: smooth edges
constexpr double kThinnestLines = 0.8;           // small pictures: lines no thinner than this share
constexpr std::size_t kScenePoints = 1'000'000;  // of map.3Dscene
constexpr int kLargestTexture = 16384;           // [px] what the software renderer can draw at once

// Points as large as the gaps between them, so that they look like a surface. Returns the size in
// the middle of the picture [px].
double sizePoints(mrpt::opengl::CPointCloudColoured& cloud, double spacing_m,
                  const ViewCamera& camera) {
  constexpr double kOverlap = 1.25;
  constexpr double kSmallestPx = 2.0;
  const double size_m = kOverlap * spacing_m;
  const double size_px = std::max(kSmallestPx, size_m / camera.metresPerPixel(camera.distance_m));
  if (camera.orthographic) {
    cloud.enableVariablePointSize(false);
    cloud.setPointSize(static_cast<float>(size_px));
    return size_px;
  }
  // The shader draws base + k / (scale * depth + 0.01) pixels.
  cloud.enableVariablePointSize(true);
  cloud.setPointSize(static_cast<float>(kSmallestPx));
  cloud.setVariablePointSize_DepthScale(1.0F);
  cloud.setVariablePointSize_k(static_cast<float>((size_px - kSmallestPx) * camera.distance_m));
  return size_px;
}

LineStyle lineStyle(const ViewCamera& camera, double scale) {
  LineStyle style;
  style.metres_per_pixel = [camera](const Eigen::Vector3d& p) {
    return camera.metresPerPixel(std::max(camera.near_m, camera.depth(p)));
  };
  style.right = camera.right();
  style.up = camera.up();
  style.track_px *= scale;
  style.link_px *= scale;
  style.triangle_px *= scale;
  return style;
}

void writePng(const fs::path& path, const cv::Mat& picture) {
  std::vector<std::uint8_t> bytes;
  if (!cv::imencode(".png", picture, bytes))
    throw RunError(fmt::format("{}: the picture cannot be coded as PNG", path.string()));
  writeFileAtomically(path, std::string(bytes.begin(), bytes.end()));
}

/// Every k-th point, so that at most about `most` are left.
std::vector<ColouredPoint> thinned(const std::vector<ColouredPoint>& cloud, std::size_t most) {
  const std::size_t step = (cloud.size() + most - 1) / most;
  if (step <= 1) return cloud;
  std::vector<ColouredPoint> out;
  out.reserve(cloud.size() / step + 1);
  for (std::size_t i = 0; i < cloud.size(); i += step) out.push_back(cloud[i]);
  return out;
}

/// Of the whole cloud, the same for every picture.
struct Measures {
  double spacing_m = 0;
  HeightRange heights;
};

Measures measure(const SceneInputs& scene) {
  return {pointSpacing(scene.cloud), heightRange(scene.cloud)};
}

/// A picture on its way.
struct Picture {
  View view;
  ImageSize size;
  fs::path png;
  ViewCamera camera;  ///< of the supersampled picture
  HeightRange heights;
  int supersampling = 1;
  double splat_px = 0;
  mrpt::opengl::CRenderizable::Ptr surface_object, line_object;
  Layer surface, lines;

  double ui() const { return camera.size.height / 1080.0; }
};

Picture prepare(const SceneInputs& scene, const Measures& measures, const View& view,
                ImageSize size, const fs::path& png) {
  Picture p;
  p.view = view;
  p.size = size;
  p.png = png;
  p.heights = measures.heights;
  p.camera = frameScene(scene, view, size);
  p.supersampling =
      std::max(size.width, size.height) * kSupersampling <= kLargestTexture ? kSupersampling : 1;
  p.camera.size = {size.width * p.supersampling, size.height * p.supersampling};
  const bool by_height = view.kind == View::Kind::kHeight;
  if (view.kind == View::Kind::kOctomap) {
    p.surface_object = voxelObject(scene.voxels, p.camera);
  } else {
    const auto cloud = cloudObject(visiblePoints(scene.cloud, p.camera, p.supersampling),
                                   by_height ? &p.heights : nullptr);
    p.splat_px = sizePoints(*cloud, measures.spacing_m, p.camera);
    p.surface_object = cloud;
  }
  if (!by_height)
    p.line_object =
        lineObject(scene, lineStyle(p.camera, std::max(p.ui(), kThinnestLines * p.supersampling)));
  return p;
}

/// All that needs the renderer.
void draw(Picture& p) {
  Offscreen offscreen(p.camera);
  p.surface = offscreen.render(p.surface_object);
  if (p.line_object) p.lines = offscreen.render(p.line_object);
  p.surface_object.reset();
  p.line_object.reset();
}

void finish(Picture& p, const SceneInputs& scene) {
  if (p.view.kind != View::Kind::kOctomap) closeGaps(p.surface, 4);
  // Seen at a grazing angle the steps between flat splats are longer in depth.
  const double steepness = std::max(1.0, 1.5 / std::tan(p.camera.elevation_deg * M_PI / 180.0));
  shadeRelief(p.surface, p.camera, 5 * p.ui(), p.splat_px * steepness, p.supersampling);
  if (!p.lines.depth.empty())
    layOver(p.surface, p.lines, static_cast<int>(std::lround(1.5 * p.ui())));
  cv::Mat picture;
  cv::resize(p.surface.colour, picture, {p.size.width, p.size.height}, 0, 0, cv::INTER_AREA);
  if (p.view.kind != View::Kind::kHeight) drawUavLegend(picture, scene, !p.camera.orthographic);
  if (scene.georeferenced) {
    drawScaleBar(picture, p.camera);
    drawNorthArrow(picture, p.camera);
  }
  if (p.view.kind == View::Kind::kHeight) drawHeightLegend(picture, p.heights, scene);
  writePng(p.png, picture);
}

/// Pictures are drawn in this thread, as OpenGL wants it; the next one is prepared and the last one
/// finished beside it, or, if not side by side, when it is its turn.
void renderAll(const SceneInputs& scene, const std::vector<View>& views, ImageSize size,
               const std::vector<fs::path>& files, bool side_by_side) {
  const Measures measures = measure(scene);
  const auto policy = side_by_side ? std::launch::async : std::launch::deferred;
  const auto prepared = [&](std::size_t i) {
    return std::async(policy, [&scene, &measures, &views, size, &files, i] {
      return prepare(scene, measures, views[i], size, files[i]);
    });
  };
  std::future<Picture> coming = prepared(0);
  std::future<void> finishing;
  for (std::size_t i = 0; i < views.size(); ++i) {
    auto picture = std::make_shared<Picture>(coming.get());
    if (i + 1 < views.size()) coming = prepared(i + 1);
    draw(*picture);
    if (finishing.valid()) finishing.get();
    finishing = std::async(policy, [&scene, picture] { finish(*picture, scene); });
    if (!side_by_side) finishing.get();
  }
  if (finishing.valid()) finishing.get();
}

}  // namespace

Eigen::Matrix<std::uint8_t, 3, 1> uavColour(bool central, std::size_t index) {
  if (central) return {255, 255, 255};
  static const std::uint8_t kColours[8][3] = {{255, 214, 0},  {0, 208, 255},  {255, 80, 255},
                                              {140, 255, 50}, {255, 140, 0},  {150, 120, 255},
                                              {0, 255, 170},  {255, 170, 190}};
  const auto& c = kColours[index % 8];
  return {c[0], c[1], c[2]};
}

void renderSnapshot(const SceneInputs& scene, const View& view, ImageSize size,
                    const fs::path& png) {
  Picture picture = prepare(scene, measure(scene), view, size, png);
  draw(picture);
  finish(picture, scene);
}

void writeScene(const SceneInputs& scene, const fs::path& file) {
  const ViewCamera camera = frameScene(scene, {View::Kind::kIso, {}}, {});
  COpenGLScene out;
  auto viewport = out.getViewport();
  viewport->setCustomBackgroundColor({kBackgroundGrey, kBackgroundGrey, kBackgroundGrey, 1.0F});
  viewport->getCamera() = mrptCamera(camera);
  viewport->setViewportClipDistances(static_cast<float>(0.05 * camera.near_m),
                                     static_cast<float>(10 * camera.far_m));
  const std::vector<ColouredPoint> points = thinned(scene.cloud, kScenePoints);
  const auto cloud = cloudObject(points, nullptr);
  cloud->setName("cloud");
  sizePoints(*cloud, pointSpacing(points), camera);
  out.insert(cloud);
  LineStyle style = lineStyle(camera, 1.0);
  style.right = Eigen::Vector3d::UnitX();
  style.up = Eigen::Vector3d::UnitY();
  const auto lines = lineObject(scene, style);
  lines->setName("trajectories and relative poses");
  out.insert(lines);
  fs::path temporary = file;
  temporary += ".tmp";
  std::error_code error, ignored;
  const bool written = out.saveToFile(temporary.string()) && syncFile(temporary);
  if (written) fs::rename(temporary, file, error);
  if (written && !error) return;
  fs::remove(temporary, ignored);
  throw RunError(
      fmt::format("{}: cannot be written{}", file.string(), error ? ": " + error.message() : ""));
}

std::vector<fs::path> renderRun(const fs::path& outdir, ImageSize size, bool side_by_side) {
  SceneLimits limits;
  limits.with_voxels = fs::exists(outdir / "octomap.ot");
  const SceneInputs scene = loadScene(outdir, limits);
  createFolder(outdir / "snapshots");
  std::vector<fs::path> written;
  std::vector<View> views;
  for (const char* name : {"top", "iso", "front", "height"}) views.push_back(parseView(name));
  std::vector<std::string> names = {"top", "iso", "front", "height"};
  if (!scene.voxels.empty()) {
    views.push_back(parseView("octomap"));
    names.push_back("octomap");
  }
  for (const auto& track : scene.tracks) {
    if (track.positions_m.empty()) continue;
    views.push_back({View::Kind::kUav, track.name});
    names.push_back("uav_" + track.name);
  }
  for (const std::string& name : names) written.push_back(outdir / "snapshots" / (name + ".png"));
  const fs::path scene_file = outdir / "map.3Dscene";
  renderAll(scene, views, size, written, side_by_side);
  writeScene(scene, scene_file);
  written.push_back(scene_file);
  return written;
}

}  // namespace cf
