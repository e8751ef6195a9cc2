// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "kd_tree.h"

namespace cf {

/// Least-squares plane of the points nearest to a query.
struct LocalPlane {
  bool determined = false;  ///< false: fewer than 3 points, or all on one line
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< upward
  double roughness = 0;  ///< variance along the normal over the total, 0 (flat) to 1/3
};

LocalPlane localPlane(const KdTree<3>& tree, const Eigen::Vector3f& query, std::size_t neighbours);

}  // namespace cf
