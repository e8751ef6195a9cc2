// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "cf/base/result.h"

namespace cf {

struct TwoViewOptions {
  double threshold = 2e-3;  ///< inlier distance on the normalized plane (pixels over focal length)
  int min_inliers = 20;
  double min_parallax_rad = 0.02;  ///< median over the inliers: less gives no depth
};

struct TwoView {
  Eigen::Isometry3d T_a_b = Eigen::Isometry3d::Identity();  ///< |translation| = 1
  std::vector<char> inlier;                                 ///< per match
  std::vector<Eigen::Vector3d> point_a;                     ///< per match, in a; zero if no inlier
  int inliers = 0;
  double median_parallax_rad = 0;
  bool planar = false;  ///< a homography explains the matches as well as the epipolar geometry
};

/// Relative pose of two calibrated views from matches on their normalized planes. Five-point
/// essential matrices (Nister 2004) and decomposed homographies (Malis & Vargas 2007) compete:
/// each hypothesis is refined on its epipolar error and scored by the truncated reprojection
/// errors of the points that it puts in front of both cameras. Deterministic.
Result<TwoView> estimateTwoView(const std::vector<Eigen::Vector2d>& a,
                                const std::vector<Eigen::Vector2d>& b,
                                const TwoViewOptions& options);

/// Matches consistent with one essential matrix or one homography, whichever holds more; per match
/// 1 or 0. A check of a pair whose pose is not asked for.
std::vector<char> consistentMatches(const std::vector<Eigen::Vector2d>& a,
                                    const std::vector<Eigen::Vector2d>& b, double threshold);

}  // namespace cf
