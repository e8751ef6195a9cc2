// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <utility>

namespace cf {

/// Heights of the topmost surface in the truth's ENU frame. Row 0 is in the north; the middle of
/// cell (column, row) lies at (west + (column + 0.5) spacing, north - (row + 0.5) spacing).
struct HeightGrid {
  double west_m = 0, north_m = 0, spacing_m = 1;
  cv::Mat heights;                     ///< CV_32FC1, NaN = none
  double least_m = 0, greatest_m = 0;  ///< of the heights

  /// Bilinear between the middles of cells; nothing beside them, where one has no height, and
  /// where they differ by more than the surface of a slope of 45 degrees would.
  std::optional<double> smoothHeight(const Eigen::Vector2d& place) const;
  /// Least and greatest height of the cells that come within `reach_m` of the place, in x and y.
  std::optional<std::pair<double, double>> heightRange(const Eigen::Vector2d& place,
                                                       double reach_m) const;
  /// Least t > 0 at which `from` + t `direction` comes to lie on or in a cell's column; nothing
  /// where it meets none on its way down.
  std::optional<double> firstHit(const Eigen::Vector3d& from,
                                 const Eigen::Vector3d& direction) const;
};

/// dsm.tif: metadata ORIGIN_E, ORIGIN_N (its north-western corner) and SPACING [m]. Throws RunError
/// where one is missing, or no cell has a height.
HeightGrid readHeightGrid(const std::filesystem::path& file);

}  // namespace cf
