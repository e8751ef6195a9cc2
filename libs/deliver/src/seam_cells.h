// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "cf/types/seam_point.h"

namespace cf {

/// How two UAVs disagree in one part of the map: the median of the points there, axis by axis, and
/// how well it is known.
struct SeamCell {
  std::uint16_t uav_a = 0, uav_b = 0;
  Eigen::Vector2d middle_m = Eigen::Vector2d::Zero();
  Eigen::Vector3d difference_m = Eigen::Vector3d::Zero();  ///< b minus a
  double sigma_m = 0;                                      ///< of the difference, over all axes
  int points = 0;
};

struct Seam {
  double cell_m = 0;
  std::vector<SeamCell> cells;  ///< with kEnough points
  double rms_m = 0;             ///< of the cells' differences, without what chance puts there
  double worst_m = 0;           ///< largest difference of a cell
  std::size_t points = 0;

  static constexpr int kEnough = 12;
};

/// None where no cell has enough points.
std::optional<Seam> seamOf(const std::vector<SeamPoint>& points);

}  // namespace cf
