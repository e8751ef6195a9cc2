// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "truth_views.h"

#include <algorithm>
#include <cmath>

#include "cf/base/error.h"
#include "cf/base/text.h"
#include "cf/formats/float_raster.h"
#include "height_grid.h"

namespace cf {
namespace {

constexpr int kThinnedPixels = 200'000, kMadePixels = 30'000;
constexpr double kSmooth = 0.02, kSameDepth = 0.01;  ///< of the depth

SparseDepth thinned(const SparseDepth& full) {
  int n = 1;
  while (full.values.rows / n * (full.values.cols / n) > kThinnedPixels) ++n;
  SparseDepth out;
  out.step = full.step * n;
  out.values.create((full.values.rows - 1) / n + 1, (full.values.cols - 1) / n + 1, CV_32FC1);
  for (int j = 0; j < out.values.rows; ++j)
    for (int i = 0; i < out.values.cols; ++i)
      out.values.at<float>(j, i) = full.values.at<float>(j * n, i * n);
  return out;
}

SparseDepth depthFrom(const HeightGrid& heights, const CameraModel& camera,
                      const Eigen::Isometry3d& T_world_cam) {
  SparseDepth out;
  while ((camera.width / out.step) * (camera.height / out.step) > kMadePixels) ++out.step;
  out.values = cv::Mat::zeros((camera.height - 1) / out.step + 1, (camera.width - 1) / out.step + 1,
                              CV_32FC1);
  for (int j = 0; j < out.values.rows; ++j)
    for (int i = 0; i < out.values.cols; ++i) {
      const Eigen::Vector2d pixel(i * out.step, j * out.step);
      const Eigen::Vector3d ray = T_world_cam.linear() * camera.undistort(pixel).homogeneous();
      if (const auto depth = heights.firstHit(T_world_cam.translation(), ray))
        out.values.at<float>(j, i) = static_cast<float>(*depth);
    }
  return out;
}

}  // namespace

double SparseDepth::at(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d p = pixel / step;
  if (!(p.minCoeff() >= 0) || p.x() > values.cols - 1 || p.y() > values.rows - 1) return 0;
  const int i = std::min(static_cast<int>(p.x()), std::max(0, values.cols - 2));
  const int j = std::min(static_cast<int>(p.y()), std::max(0, values.rows - 2));
  const double u = p.x() - i, v = p.y() - j;
  double sum = 0, low = 0, high = 0;
  for (int dj = 0; dj < 2; ++dj)
    for (int di = 0; di < 2; ++di) {
      const double weight = (di == 1 ? u : 1 - u) * (dj == 1 ? v : 1 - v);
      if (weight <= 0) continue;
      const auto z = static_cast<double>(values.at<float>(j + dj, i + di));
      if (!(z > 0)) return 0;
      low = low > 0 ? std::min(low, z) : z;
      high = std::max(high, z);
      sum += weight * z;
    }
  return high - low <= kSmooth * low ? sum : 0;
}

SparseDepth readSparseDepth(const std::filesystem::path& file) {
  const FloatRaster raster = readFloatRaster(file);
  const auto step = raster.metadata.find("STEP");
  const auto value = step == raster.metadata.end() ? std::nullopt : numberFrom(step->second);
  if (!value || *value < 1 || *value > 1e4)
    throw RunError(file.string() + ": needs the TIFF metadata item STEP, pixels of the photo");
  return {static_cast<int>(*value), raster.values};
}

bool TruthView::sees(const Eigen::Vector3d& p_world, Eigen::Vector2d& pixel) const {
  const Eigen::Vector3d p = T_cam_world * p_world;
  if (p.z() <= 0) return false;
  // Far off the image the distortion may fold back into it.
  const Eigen::Vector2d n = p.hnormalized();
  constexpr double kMargin = 1.3;
  if (std::abs(n.x()) > kMargin * camera->width / camera->fx / 2 ||
      std::abs(n.y()) > kMargin * camera->height / camera->fy / 2)
    return false;
  pixel = camera->distort(n);
  if (!camera->contains(pixel)) return false;
  return std::abs(depth.at(pixel) - p.z()) <= kSameDepth * p.z();
}

std::filesystem::path depthFile(const std::filesystem::path& folder, const RunUav& uav,
                                const RunPhoto& photo) {
  return folder / "depth" / uav.name / (std::filesystem::path(photo.name).stem().string() + ".tif");
}

std::vector<TruthView> readTruthViews(const RunInputs& run) {
  std::vector<TruthView> views;
  std::optional<HeightGrid> heights;
  if (std::filesystem::exists(run.truth_dir / "dsm.tif"))
    heights = readHeightGrid(run.truth_dir / "dsm.tif");
  for (std::size_t u = 0; u < run.uavs.size(); ++u) {
    const RunUav& uav = run.uavs[u];
    if (!uav.camera_true) continue;
    for (std::size_t k = 0; k < uav.photos.size(); ++k) {
      const std::filesystem::path file = depthFile(run.truth_dir, uav, uav.photos[k]);
      TruthView view;
      view.mapped = std::filesystem::exists(file);
      if (!view.mapped && !heights) continue;
      view.uav = u;
      view.photo = k;
      view.T_cam_world = uav.photos[k].truth.inverse();
      view.camera = &*uav.camera_true;
      view.depth = view.mapped ? thinned(readSparseDepth(file))
                               : depthFrom(*heights, *view.camera, uav.photos[k].truth);
      views.push_back(std::move(view));
    }
  }
  return views;
}

}  // namespace cf
