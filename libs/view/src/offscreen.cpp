// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "offscreen.h"

#include <fmt/format.h>
#include <mrpt/opengl/CFBORender.h>
#include <mrpt/opengl/COpenGLScene.h>

#include <algorithm>
#include <string>

#include "cf/base/error.h"

namespace cf {
namespace {

// MRPT converts the depth buffer as if every camera were a perspective one: undo it, then apply
// the parallel projection's linear depth.
void makeDepthParallel(cv::Mat& depth, float near_m, float far_m) {
  for (int y = 0; y < depth.rows; ++y) {
    auto* row = depth.ptr<float>(y);
    for (int x = 0; x < depth.cols; ++x) {
      if (row[x] <= 0) continue;
      const float share = (far_m + near_m - 2 * near_m * far_m / row[x]) / (far_m - near_m);
      row[x] = near_m + (share + 1) / 2 * (far_m - near_m);
    }
  }
}

std::unique_ptr<mrpt::opengl::CFBORender> makeRenderer(ImageSize size) {
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

}  // namespace

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

Offscreen::Offscreen(const ViewCamera& camera)
    : camera_(camera), renderer_(makeRenderer(camera.size)) {}

Offscreen::~Offscreen() = default;

Layer Offscreen::render(const mrpt::opengl::CRenderizable::Ptr& object) {
  mrpt::opengl::COpenGLScene scene;
  auto viewport = scene.getViewport();
  viewport->setCustomBackgroundColor({kBackgroundGrey, kBackgroundGrey, kBackgroundGrey, 1.0F});
  const auto near_m = static_cast<float>(camera_.near_m);
  const auto far_m = static_cast<float>(camera_.far_m);
  viewport->setViewportClipDistances(near_m, far_m);
  if (object) scene.insert(object);
  renderer_->setCamera(scene, mrptCamera(camera_));
  mrpt::img::CImage image;
  mrpt::math::CMatrixFloat depth;
  renderer_->render_RGBD(scene, image, depth);
  Layer layer;
  layer.colour = image.asCvMat<cv::Mat>(mrpt::img::SHALLOW_COPY);
  layer.depth = cv::Mat(static_cast<int>(depth.rows()), static_cast<int>(depth.cols()), CV_32FC1,
                        depth.data())
                    .clone();
  if (camera_.orthographic) makeDepthParallel(layer.depth, near_m, far_m);
  return layer;
}

}  // namespace cf
