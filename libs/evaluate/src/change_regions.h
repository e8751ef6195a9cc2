// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "height_change.h"

namespace cf {

/// Connected ground that has risen or fallen significantly.
struct ChangeRegion {
  bool gain = false;  ///< B above A
  std::size_t cells = 0;
  double area_m2 = 0, volume_m3 = 0, volume_sigma_m3 = 0;
  double mean_m = 0, extreme_m = 0;                    ///< height difference, signed
  Eigen::Vector2d middle_m = Eigen::Vector2d::Zero();  ///< easting, northing
};

struct ChangeRegions {
  std::vector<ChangeRegion> regions;  ///< by volume, largest first
  cv::Mat label;                      ///< CV_32SC1: number of the region from 1, 0 elsewhere
};

/// Significance from which a difference counts.
inline constexpr double kSignificant = 3;

/// Cells of significance 3 joined at their sides and corners, and of one sign; cells at most four
/// from such ones join them where an edge alone makes their sigma large (the rim of what has
/// come or gone). Smaller ones than `min_area_m2`, and such with less than half of that without
/// their rim, do not count.
ChangeRegions changeRegions(const HeightChange& change, const SurfaceRegistration& registration,
                            double min_area_m2);

}  // namespace cf
