// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

namespace cf {

/// A camera of the adjustment: T_local_cam.
struct AdjustedPose {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
  bool held = false;
  bool length_held = false;  ///< |t| stays
};

/// A point on the ray of its anchor, and where other photos see it on their normalized planes.
struct AdjustedPoint {
  struct Sighting {
    int pose = 0;
    Eigen::Vector2d normalized = Eigen::Vector2d::Zero();
  };
  int anchor = 0;  ///< pose
  Eigen::Vector2d anchor_normalized = Eigen::Vector2d::Zero();
  double inverse_depth = 0;
  std::vector<Sighting> sightings;  ///< each from another pose than the anchor's and each other's
};

/// Minimises equation (1), the robust sum of the residuals of equation (3), over poses and inverse
/// depths (equation (2)), in place.
/// A residual beyond `huber` on the normalized plane counts linearly. Levenberg-Marquardt; the
/// inverse depths, each a number of its own, are eliminated (Schur). Deterministic. False, and
/// nothing is changed, where a point starts behind a camera that sees it.
bool solveInverseDepths(std::vector<AdjustedPose>& poses, std::vector<AdjustedPoint>& points,
                        double huber);

}  // namespace cf
