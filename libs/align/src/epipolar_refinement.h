// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <vector>

namespace cf {

struct EpipolarPose {
  Eigen::Isometry3d T_a_b = Eigen::Isometry3d::Identity();  ///< |translation| = 1
  /// First order, from the Sampson errors: tilt of the translation (2, about two axes normal to
  /// it), rotation vector (3, in b: R_a_b exp(w)).
  Eigen::Matrix<double, 5, 5> covariance = Eigen::Matrix<double, 5, 5>::Zero();
  double sigma = 0;  ///< of a Sampson error
};

/// Robust least squares on the Sampson errors of the inliers, whose own spread scales the loss.
EpipolarPose refineEpipolar(const Eigen::Isometry3d& T_a_b, const std::vector<Eigen::Vector2d>& a,
                            const std::vector<Eigen::Vector2d>& b, const std::vector<char>& inlier);

}  // namespace cf
