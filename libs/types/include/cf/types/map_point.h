// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace cf {

/// A triangulated pixel of a depth frame, on its way into the map.
struct MapPoint {
  Eigen::Vector3f position_m = Eigen::Vector3f::Zero();  ///< relative to MapPoints::origin_m
  std::uint8_t bgr[3] = {0, 0, 0};
  float weight = 0;  ///< inverse variance up to a common factor
};

/// Points around a common origin: as floats they are exact to 0.02 mm within 250 m of it, wherever
/// in the world it lies.
struct MapPoints {
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();  ///< world
  std::vector<MapPoint> points;

  Eigen::Vector3d world(const MapPoint& point) const {
    return origin_m + point.position_m.cast<double>();
  }
};

}  // namespace cf
