// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <map>
#include <vector>

#include "cf/types/camera_model.h"
#include "cf/types/feature_set.h"
#include "cf/types/ids.h"

namespace cf {

/// How well a pose is known: translation [m], then rotation vector [rad], both in world (left
/// perturbation); zero = unknown.
struct PoseCovariance {
  Eigen::Matrix<double, 6, 6> in_world = Eigen::Matrix<double, 6, 6>::Zero();
  /// What is left when the map of its component has been fitted to the truth by one similarity: how
  /// photos lie to each other, without where the map lies as a whole.
  Eigen::Matrix<double, 6, 6> in_map = Eigen::Matrix<double, 6, 6>::Zero();
};

/// Where every photo is, as known at one version. Later versions replace earlier ones as a whole.
struct PoseTable {
  struct Entry {
    Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
    PoseCovariance covariance;
    int component = 0;          ///< photos joined by matches share one; 0 holds the central UAV
    double median_depth_m = 0;  ///< of its triangulated features; 0 = unknown
    /// 5th and 95th percentile of those depths, for the search range of dense matching.
    double near_depth_m = 0, far_depth_m = 0;
  };
  std::uint32_t version = 0;
  std::map<FrameId, Entry> poses;
  std::vector<CameraModel> cameras;  ///< by UAV
};

/// A feature that sees a point of the joint map.
struct SparseObservation {
  FrameId frame;
  int feature = 0;
};

/// A triangulated feature of the joint map.
struct SparsePoint {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< world
  std::uint8_t bgr[3] = {0, 0, 0};
  std::vector<SparseObservation> observations;
};

/// A relative pose of two photos of different UAVs (or segments) observed from their features.
struct RelativePose {
  FrameId a, b;
  int inliers = 0;
  Eigen::Isometry3d T_a_b = Eigen::Isometry3d::Identity();  ///< metres, by the map's scale
  Eigen::Matrix<double, 6, 1> sigma = Eigen::Matrix<double, 6, 1>::Zero();  ///< t [m], r [rad]
  /// Of the translation against the georeferenced poses [m]; 0 where one is not georeferenced.
  double residual_before = 0;
  double residual_after = 0;  ///< against the final PoseTable [m]
};

}  // namespace cf
