// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "cf/base/result.h"

namespace cf {

struct HomographyOptions {
  double threshold = 2e-3;  ///< inlier distance on the normalized plane (pixels over focal length)
  int min_inliers = 20;
};

/// What is known before: it picks one of the decompositions and, for the normal, steadies what a
/// short baseline does not show.
struct PlanePrior {
  std::optional<Eigen::Vector3d> normal_a;  ///< unit, in a, from camera a towards the plane
  double normal_sigma_rad = 0.3;
  std::optional<Eigen::Matrix3d> R_a_b;
  double rotation_sigma_rad = 0.3;
};

/// Motion over a plane n . p_a = d, in units of d: the length of a translation is not in a
/// homography.
struct PlaneMotion {
  Eigen::Isometry3d T_a_b = Eigen::Isometry3d::Identity();  ///< translation over d
  Eigen::Vector3d normal_a = Eigen::Vector3d::UnitZ();      ///< unit, from camera a to the plane
  double prior_cost = 0;  ///< squared sigmas by which it misses the prior; 0 without one
};

struct PlanarPose {
  PlaneMotion motion;
  std::vector<PlaneMotion> alternatives;  ///< also in front of both cameras, less like the prior
  std::vector<char> inlier;               ///< per match
  int inliers = 0;
  double sigma = 0;  ///< of one coordinate of the transfer error, normalized plane
  /// Order: translation over d (3, in a), rotation vector (3, in b: R_a_b exp(w)), tilt of the
  /// normal (2, about two axes normal to it). First order, from the inliers' Jacobian and sigma.
  Eigen::Matrix<double, 8, 8> covariance = Eigen::Matrix<double, 8, 8>::Zero();
  /// Sigma of the direction of the translation; above 0.5 the cameras did little but turn, and
  /// the direction says nothing.
  double direction_sigma_rad = 0;
};

/// Pose of camera b against a from matches of a (mostly) planar scene on their normalized planes:
/// MAGSAC homography (Barath 2019), decomposed (Malis & Vargas 2007), chosen among the four by
/// points in front of both cameras and the prior, then all 8 parameters refined by robust least
/// squares on the transfer error. Deterministic.
Result<PlanarPose> estimatePlanarPose(const std::vector<Eigen::Vector2d>& a,
                                      const std::vector<Eigen::Vector2d>& b,
                                      const PlanePrior& prior, const HomographyOptions& options);

/// The motion that fits the inliers best, from one near it: the last step of estimatePlanarPose.
/// `sigma` as in PlanarPose.
PlaneMotion refinePlaneMotion(const std::vector<Eigen::Vector2d>& a,
                              const std::vector<Eigen::Vector2d>& b,
                              const std::vector<char>& inlier, double sigma,
                              const PlaneMotion& start, const PlanePrior& prior);

/// Where the motion takes a point of a's normalized plane that lies on the plane, in b: direction,
/// positive z in front.
Eigen::Vector3d transfer(const PlaneMotion& motion, const Eigen::Vector2d& a);

}  // namespace cf
