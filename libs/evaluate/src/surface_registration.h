// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "cf/base/result.h"
#include "run_surface.h"

namespace cf {

/// How the surface of run B was brought onto that of run A: p_a = middle + shift +
/// scale R (p_b - middle), in easting, northing and height.
struct SurfaceRegistration {
  Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  double scale = 1;
  /// Of shift [m], rotation vector [rad] and the logarithm of the scale, about the middle.
  Eigen::Matrix<double, 7, 7> covariance = Eigen::Matrix<double, 7, 7>::Zero();
  double stable_share = 0;  ///< of the common ground, within three NMAD
  double nmad_m = 0;        ///< of the height differences that are left, at `sample_m`
  double sample_m = 0;
  std::size_t samples = 0;

  Eigen::Vector3d toA(const Eigen::Vector3d& p_b) const {
    return middle_m + shift_m + scale * (rotation * (p_b - middle_m));
  }
  Eigen::Vector3d toB(const Eigen::Vector3d& p_a) const {
    return middle_m + rotation.transpose() * (p_a - middle_m - shift_m) / scale;
  }
  /// Variance [m^2] of the height difference at a place where the surface rises by `slope` (per
  /// metre east and north).
  double heightVariance(const Eigen::Vector3d& p_a, const Eigen::Vector2d& slope) const;
};

/// Coarse by the grid coordinates and registerClouds(); then shift, rotation and scale by least
/// squares over the height differences of smooth ground with Tukey weights, so that what has
/// changed does not count. What heights do not determine (a flat place slides, turns and grows)
/// stays as the coarse step left it, within a prior of 1 m, 1 degree and 1 %. The covariance is
/// that of squares of 10 m whose errors are independent (cluster-robust sandwich). Fails where too
/// little ground is common or too little of it agrees.
Result<SurfaceRegistration> registerSurfaces(const RunSurface& a, const RunSurface& b);

}  // namespace cf
