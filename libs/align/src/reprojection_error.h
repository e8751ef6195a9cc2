// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ceres/sized_cost_function.h>

#include <Eigen/Geometry>
#include <array>

#include "cf/types/camera_model.h"

namespace cf {

/// Lens of one UAV in units that do not depend on the photo's size: focal length over width, k1,
/// k2, p1, p2, and the principal point from the photo's left and top edge over width.
constexpr int kLens = 7;
using Lens = std::array<double, kLens>;

Lens lensOf(const CameraModel& camera);
CameraModel withLens(CameraModel camera, const Lens& lens);

/// T_world_cam: quaternion w x y z, then translation. One block: Ceres' Schur complement has a
/// quarter of the cells that two would give it.
constexpr int kPose = 7;
using PoseBlock = std::array<double, kPose>;

PoseBlock poseBlockOf(const Eigen::Isometry3d& T_world_cam);
Eigen::Isometry3d poseOf(const PoseBlock& block);

/// Equation (3) with the distorted pixel of a world point: where it projects minus where it was
/// seen, in sigmas. Derivatives by hand: most of the time of a joint adjustment goes here.
class ReprojectionError : public ceres::SizedCostFunction<2, kPose, 3, kLens> {
 public:
  /// `pixel` as FeatureSet's; of `camera` the size, the aspect and k3 stay as they are.
  ReprojectionError(const Eigen::Vector2d& pixel, const CameraModel& camera, double sigma_px);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  double x_, y_;  ///< seen, from the photo's corner [px]
  double width_, aspect_, k3_, inverse_sigma_;
};

}  // namespace cf
