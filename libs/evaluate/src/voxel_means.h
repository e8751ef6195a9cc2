// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <vector>

namespace cf {

/// Mean of the points of each occupied cube of side `voxel_m` within `box`, in a fixed order.
/// The box may be at most 2^21 voxels long.
std::vector<Eigen::Vector3f> voxelMeans(const std::vector<Eigen::Vector3f>& points,
                                        const Eigen::AlignedBox3f& box, double voxel_m);

/// Every n-th point, n the smallest that leaves at most `limit` of them.
std::vector<Eigen::Vector3f> everyNth(const std::vector<Eigen::Vector3f>& points,
                                      std::size_t limit);

}  // namespace cf
