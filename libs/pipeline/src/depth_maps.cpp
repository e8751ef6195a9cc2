// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "depth_maps.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <string>

namespace cf {
namespace {

constexpr float kSameSurface = 0.01F;  ///< of the depth

}  // namespace

DepthMaps::Map DepthMaps::emptyMap(const CameraModel& camera) const {
  const double pixels = static_cast<double>(camera.width) * camera.height;
  Map map;
  map.step = std::max(1, static_cast<int>(std::lround(std::sqrt(pixels / (megapixels_ * 1e6)))));
  const cv::Size size((camera.width - 1) / map.step + 1, (camera.height - 1) / map.step + 1);
  map.depth = cv::Mat::zeros(size, CV_32FC1);
  map.weight = cv::Mat::zeros(size, CV_32FC1);
  return map;
}

void DepthMaps::add(const DenseView& photo, const MapPoints& points) {
  auto found = maps_.find(photo.id);
  if (found == maps_.end()) found = maps_.emplace(photo.id, emptyMap(photo.camera)).first;
  Map& map = found->second;
  const Eigen::Isometry3d T_cam_points =
      photo.T_world_cam.inverse() * Eigen::Translation3d(points.origin_m);
  for (const MapPoint& point : points.points) {
    const Eigen::Vector3d p_cam = T_cam_points * point.position_m.cast<double>();
    if (p_cam.z() <= 0 || point.weight <= 0) continue;
    const Eigen::Vector2d pixel = photo.camera.project(p_cam) / map.step;
    if (!pixel.allFinite()) continue;
    const Eigen::Vector2d nearest = pixel.array().round();
    if (nearest.x() < 0 || nearest.y() < 0 || nearest.x() >= map.depth.cols ||
        nearest.y() >= map.depth.rows)
      continue;
    const int i = static_cast<int>(nearest.x()), j = static_cast<int>(nearest.y());
    float &depth = map.depth.at<float>(j, i), &weight = map.weight.at<float>(j, i);
    const float z = static_cast<float>(p_cam.z()), w = point.weight;
    if (weight > 0 && std::abs(z - depth) <= kSameSurface * depth) {
      depth += (z - depth) * w / (weight + w);
      weight += w;
    } else if (w > weight) {
      depth = z;
      weight = w;
    }
  }
}

std::optional<FloatRaster> DepthMaps::take(FrameId photo) {
  const auto map = maps_.extract(photo);
  if (map.empty() || cv::countNonZero(map.mapped().depth) == 0) return std::nullopt;
  FloatRaster raster;
  raster.values = map.mapped().depth;
  raster.metadata["STEP"] = std::to_string(map.mapped().step);
  return raster;
}

}  // namespace cf
