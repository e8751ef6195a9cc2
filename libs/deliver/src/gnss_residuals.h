// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "cf/deliver/run_record.h"

namespace cf {

/// A fix against the final map.
struct GnssResidual {
  std::uint32_t photo = 0;
  Eigen::Vector3d place_m = Eigen::Vector3d::Zero();     ///< of the camera, world
  Eigen::Vector3d residual_m = Eigen::Vector3d::Zero();  ///< fix minus camera
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Ones();     ///< as tagged
};

/// In order of the photos: of those with a fix and a final pose.
std::vector<GnssResidual> gnssResiduals(const UavRecord& uav);

/// Median residual of a UAV: what its receiver is off, against the map.
Eigen::Vector3d gnssOffset(const std::vector<GnssResidual>& residuals);

/// How much more the fixes of a UAV scatter about its offset than it tags: root mean square over
/// the axes of robust σ over tagged σ. 0 with fewer than three.
double gnssNoiseRatio(const std::vector<GnssResidual>& residuals);

/// The bend of the map against the heights of all receivers: of the fit of an offset for each UAV
/// and x, y, x², xy, y² to their height residuals, what the last three terms span over the photos.
struct Bend {
  double span_m = 0;
  double sigma_m = 0;  ///< of the span; noise that follows each other in time counts as less photos
};

/// None where there are too few fixes, or their places do not tell a bend from a tilt.
std::optional<Bend> bendAgainstGnss(const RunRecord& run);

}  // namespace cf
