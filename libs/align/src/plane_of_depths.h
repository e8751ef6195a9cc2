// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace cf {

/// Fewer depths of a photo say nothing.
inline constexpr int kMinDepths = 10;

/// Unit normal of the plane that fits the depths (0 = unknown) of points of the normalized plane:
/// 1/z is linear in their coordinates, with gradient normal/distance. Iteratively reweighted, so
/// that trees and roofs do not tilt it. None where there are too few.
std::optional<Eigen::Vector3d> normalOfDepths(const std::vector<Eigen::Vector2d>& points,
                                              const std::vector<double>& depths);

}  // namespace cf
