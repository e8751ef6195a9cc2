// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "cf/base/result.h"
#include "cf/geometry/two_view.h"

namespace cf {

/// A landmark of the local frame and where the photo to be posed sees it on its normalized plane.
struct LandmarkSight {
  Eigen::Vector3d p_local = Eigen::Vector3d::Zero();
  Eigen::Vector2d normalized = Eigen::Vector2d::Zero();
};

/// How far the pose lets the corners of a photo stray that reaches to `corner` on its normalized
/// plane: the largest standard deviation there, if each landmark is seen with an error of `sigma`.
/// Infinite where the landmarks do not hold the pose. A few landmarks along one edge, as photos of
/// little overlap have in common, hold a pose there alone.
double strayAtCorners(const Eigen::Isometry3d& T_local_cam, const std::vector<LandmarkSight>& seen,
                      const Eigen::Vector2d& corner, double sigma);

/// Pose from the two-view geometry with a posed photo `a`; landmarks give no more than the length
/// of the baseline, so that a handful will do: those, `least_landmarks` or more, that the photo
/// then sees within `threshold`, must be most of them. Fails otherwise: "no_scale".
Result<Eigen::Isometry3d> poseByScaledTwoView(const Eigen::Isometry3d& T_local_a,
                                              const Eigen::Isometry3d& T_a_cam_up_to_scale,
                                              const std::vector<LandmarkSight>& seen,
                                              double threshold, int least_landmarks);

}  // namespace cf
