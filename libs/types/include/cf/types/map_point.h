// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace cf {

/// A triangulated pixel of a depth frame, on its way into the map.
struct MapPoint {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< world
  std::uint8_t bgr[3] = {0, 0, 0};
  float weight = 0;  ///< inverse variance up to a common factor
};

}  // namespace cf
