// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "cf/base/result.h"

namespace cf {

struct PnpOptions {
  double threshold = 4e-3;  ///< inlier distance on the normalized plane
  int min_inliers = 15;
};

struct ResectedPose {
  Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
  std::vector<char> inlier;
  int inliers = 0;
};

/// Pose of a calibrated camera from world points and where they are seen on its normalized plane:
/// RANSAC over AP3P (Ke & Roumeliotis 2017), SQPnP of its inliers (Terzakis & Lourakis 2020), then
/// least squares of the inliers, twice. Level ground is as good as relief. Deterministic.
Result<ResectedPose> resect(const std::vector<Eigen::Vector3d>& p_world,
                            const std::vector<Eigen::Vector2d>& normalized,
                            const PnpOptions& options);

}  // namespace cf
