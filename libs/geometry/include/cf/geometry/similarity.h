// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "cf/base/result.h"
#include "cf/types/sim3.h"

namespace cf {

/// How two point sets may differ.
enum class AlignmentModel { kSe3, kSim3, kYaw4 };  ///< yaw4: rotation about z and translation

/// Least-squares similarity S_a_b of pairs (a[i], b[i]) (Umeyama 1991), weighted where `weights` is
/// not empty. Fails on fewer than 3 pairs (2 for yaw4) or, but for yaw4, on points on one line.
Result<Sim3> alignPoints(const std::vector<Eigen::Vector3d>& a,
                         const std::vector<Eigen::Vector3d>& b, AlignmentModel model,
                         const std::vector<double>& weights = {});

/// Robust alignment: RANSAC on minimal samples with inlier distance `threshold` in units of a,
/// then refitted to the inliers. Deterministic for one seed. Fails on fewer than `min_inliers`.
struct RobustAlignment {
  Sim3 S_a_b;
  std::vector<char> inlier;
  int inliers = 0;
};
Result<RobustAlignment> alignPointsRobust(const std::vector<Eigen::Vector3d>& a,
                                          const std::vector<Eigen::Vector3d>& b,
                                          AlignmentModel model, double threshold, int min_inliers,
                                          unsigned seed);

}  // namespace cf
