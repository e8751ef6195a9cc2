// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <vector>

namespace cf {

/// Starting guesses T_ref_est for a registration, best first, at most `count`: the horizontal
/// shifts within 12 m under which the heights of the two clouds, on a grid of `cell_m`, differ
/// most nearly by a plane (a vertical shift and a small tilt). Empty without overlap.
std::vector<Eigen::Isometry3d> searchByHeight(const std::vector<Eigen::Vector3f>& estimate,
                                              const std::vector<Eigen::Vector3f>& reference,
                                              double cell_m, std::size_t count);

}  // namespace cf
