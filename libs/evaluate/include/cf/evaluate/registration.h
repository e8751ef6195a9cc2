// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "cf/base/result.h"

namespace cf {

/// How one cloud of a scene seen from above was moved onto another of the same scene.
struct Registration {
  Eigen::Isometry3d T_ref_est = Eigen::Isometry3d::Identity();
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();  ///< of the estimate's centroid
  double rotation_deg = 0;
  double inlier_share = 0;  ///< of the last pairs, within 4.7 sigma
  double inlier_rms_m = 0;  ///< their point-to-plane distance
};

/// Rigid registration without a starting guess but north up and metres: first the heights of both
/// are compared on a grid under all horizontal shifts up to 12 m, any vertical shift and small
/// tilts; then point-to-plane ICP (Chen and Medioni 1992) with Tukey weights from the residuals'
/// spread, coarse to fine. Deterministic. Fails where the clouds do not overlap.
Result<Registration> registerClouds(const std::vector<Eigen::Vector3f>& estimate,
                                    const std::vector<Eigen::Vector3f>& reference);

}  // namespace cf
