// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace cf {

/// A ground point that two UAVs have seen, and where each of them alone says it is.
struct SeamPoint {
  std::uint16_t uav_a = 0, uav_b = 0;                      ///< a < b
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();    ///< world, the middle of both
  Eigen::Vector3d difference_m = Eigen::Vector3d::Zero();  ///< by b minus by a
};

}  // namespace cf
