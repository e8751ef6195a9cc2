// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/view/render.h"

#include <fmt/format.h>
#include <mrpt/opengl/CFBORender.h>
#include <mrpt/opengl/COpenGLScene.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "cf/base/error.h"
#include "cf/base/log.h"
#include "cf/formats/atomic_file.h"
#include "compose.h"
#include "overlay.h"
#include "scene_objects.h"

namespace cf {
namespace {

namespace fs = std::filesystem;
using mrpt::opengl::COpenGLScene;

constexpr int kSupersampling = 2;           // each pixel is the mean of 2 x 2: smooth edges
constexpr double kThinnestLines = 0.8;      // small pictures: lines no thinner than this share
constexpr int kLargestTexture = 16384;      // [px] what the software renderer can draw at once
constexpr double kBackground = 30 / 255.0;  // dark, neutral

mrpt::opengl::CCamera mrptCamera(const ViewCamera& camera) {
  mrpt::opengl::CCamera out;
  const Eigen::Vector3f target = camera.target_m.cast<float>();
  out.setPointingAt(target.x(), target.y(), target.z());
  out.setAzimuthDegrees(static_cast<float>(camera.azimuth_deg));
  out.setElevationDegrees(static_cast<float>(camera.elevation_deg));
  out.setZoomDistance(static_cast<float>(camera.distance_m));
  out.setOrthogonal(camera.orthographic);
  out.setProjectiveFOVdeg(static_cast<float>(ViewCamera::kFieldOfViewDeg));
  return out;
}

// MRPT converts the depth buffer as if every camera were a perspective one: undo it, then apply
// the parallel projection's linear depth.
void makeDepthParallel(cv::Mat& depth, float near_m, float far_m) {
  for (int y = 0; y < depth.rows; ++y)
    for (int x = 0; x < depth.cols; ++x) {
      auto& d = depth.at<float>(y, x);
      if (d <= 0) continue;
      const float share = (far_m + near_m - 2 * near_m * far_m / d) / (far_m - near_m);
      d = near_m + (share + 1) / 2 * (far_m - near_m);
    }
}

class Offscreen {
 public:
  explicit Offscreen(const ViewCamera& camera)
      : camera_(camera), renderer_(makeRenderer(camera.size)) {}

  Layer render(const mrpt::opengl::CRenderizable::Ptr& object) {
    COpenGLScene scene;
    auto viewport = scene.getViewport();
    const auto grey = static_cast<float>(kBackground);
    viewport->setCustomBackgroundColor({grey, grey, grey, 1.0F});
    const auto near_m = static_cast<float>(camera_.near_m);
    const auto far_m = static_cast<float>(camera_.far_m);
    viewport->setViewportClipDistances(near_m, far_m);
    if (object) scene.insert(object);
    renderer_->setCamera(scene, mrptCamera(camera_));
    mrpt::img::CImage image;
    mrpt::math::CMatrixFloat depth;
    renderer_->render_RGBD(scene, image, depth);
    Layer layer;
    layer.colour = image.asCvMat<cv::Mat>(mrpt::img::DEEP_COPY);
    layer.depth = cv::Mat(static_cast<int>(depth.rows()), static_cast<int>(depth.cols()), CV_32FC1,
                          depth.data())
                      .clone();
    if (camera_.orthographic) makeDepthParallel(layer.depth, near_m, far_m);
    return layer;
  }

 private:
  static std::unique_ptr<mrpt::opengl::CFBORender> makeRenderer(ImageSize size) {
    try {
      return std::make_unique<mrpt::opengl::CFBORender>(static_cast<unsigned>(size.width),
                                                        static_cast<unsigned>(size.height));
    } catch (const std::exception& e) {
      std::string reason = e.what();
      std::replace(reason.begin(), reason.end(), '\n', ' ');
      throw RunError(fmt::format(
          "cannot start the offscreen renderer ({}): install libegl-mesa0 and libgl1-mesa-dri",
          reason.substr(0, 200)));
    }
  }

  ViewCamera camera_;
  std::unique_ptr<mrpt::opengl::CFBORender> renderer_;
};

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
  cloud.setPointSize(1.0F);
  cloud.setVariablePointSize_DepthScale(1.0F);
  cloud.setVariablePointSize_k(static_cast<float>(size_m / camera.metresPerPixel(1)));
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
  cv::imencode(".png", picture, bytes);
  writeFileAtomically(path, std::string(bytes.begin(), bytes.end()));
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
  ViewCamera camera = frameScene(scene, view, size);
  const int supersampling =
      std::max(size.width, size.height) * kSupersampling <= kLargestTexture ? kSupersampling : 1;
  camera.size = {size.width * supersampling, size.height * supersampling};

  Offscreen offscreen(camera);
  const HeightRange heights = heightRange(scene.cloud);
  Layer surface;
  double splat_px = 0;
  if (view.kind == View::Kind::kOctomap) {
    surface = offscreen.render(voxelObject(scene.voxels));
  } else {
    const bool by_height = view.kind == View::Kind::kHeight;
    const auto cloud = cloudObject(scene.cloud, by_height ? &heights : nullptr);
    splat_px = sizePoints(*cloud, pointSpacing(scene.cloud), camera);
    surface = offscreen.render(cloud);
    closeGaps(surface, 4);
  }
  const double ui = camera.size.height / 1080.0;
  // Seen at a grazing angle the steps between flat splats are longer in depth.
  const double steepness = std::max(1.0, 1.5 / std::tan(camera.elevation_deg * M_PI / 180.0));
  shadeRelief(surface, camera, 5 * ui, splat_px * steepness);
  if (view.kind != View::Kind::kHeight)
    layOver(surface,
            offscreen.render(
                lineObject(scene, lineStyle(camera, std::max(ui, kThinnestLines * supersampling)))),
            static_cast<int>(std::lround(1.5 * ui)));

  cv::Mat picture;
  cv::resize(surface.colour, picture, {size.width, size.height}, 0, 0, cv::INTER_AREA);
  if (view.kind != View::Kind::kHeight) drawUavLegend(picture, scene, !camera.orthographic);
  if (scene.georeferenced) {
    drawScaleBar(picture, camera);
    drawNorthArrow(picture, camera);
  }
  if (view.kind == View::Kind::kHeight) drawHeightLegend(picture, heights, scene);
  writePng(png, picture);
}

void writeScene(const SceneInputs& scene, const fs::path& file) {
  const ViewCamera camera = frameScene(scene, {View::Kind::kIso, {}}, {});
  COpenGLScene out;
  auto viewport = out.getViewport();
  const auto grey = static_cast<float>(kBackground);
  viewport->setCustomBackgroundColor({grey, grey, grey, 1.0F});
  viewport->getCamera() = mrptCamera(camera);
  viewport->setViewportClipDistances(static_cast<float>(0.05 * camera.near_m),
                                     static_cast<float>(10 * camera.far_m));
  const auto cloud = cloudObject(scene.cloud, nullptr);
  cloud->setName("cloud");
  sizePoints(*cloud, pointSpacing(scene.cloud), camera);
  out.insert(cloud);
  LineStyle style = lineStyle(camera, 1.0);
  style.right = Eigen::Vector3d::UnitX();
  style.up = Eigen::Vector3d::UnitY();
  const auto lines = lineObject(scene, style);
  lines->setName("trajectories and relative poses");
  out.insert(lines);
  fs::path temporary = file;
  temporary += ".tmp";
  std::error_code error;
  if (!out.saveToFile(temporary.string()))
    throw RunError(fmt::format("{}: cannot be written", file.string()));
  fs::rename(temporary, file, error);
  if (error) throw RunError(fmt::format("{}: {}", file.string(), error.message()));
}

std::vector<fs::path> renderRun(const fs::path& outdir, ImageSize size) {
  SceneLimits limits;
  limits.with_voxels = fs::exists(outdir / "octomap.ot");
  const SceneInputs scene = loadScene(outdir, limits);
  fs::create_directories(outdir / "snapshots");
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
  for (std::size_t i = 0; i < views.size(); ++i) {
    written.push_back(outdir / "snapshots" / (names[i] + ".png"));
    renderSnapshot(scene, views[i], size, written.back());
  }
  written.push_back(outdir / "map.3Dscene");
  writeScene(scene, written.back());
  return written;
}

}  // namespace cf
