// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "cf/base/result.h"
#include "cf/types/camera_model.h"
#include "cf/types/feature_set.h"

namespace cf {

/// One sight of a point: the camera's pose and the point on its normalized plane z = 1.
struct Sight {
  Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
  Eigen::Vector2d normalized = Eigen::Vector2d::Zero();
};

struct Triangulated {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< world
  double max_error = 0;      ///< largest distance to a sight on the normalized plane
  double max_angle_rad = 0;  ///< largest angle between two rays
};

/// Point nearest to all rays in the least-squares sense, then Gauss-Newton on the normalized plane.
/// Fails where the rays are parallel or the point lies behind a camera.
Result<Triangulated> triangulate(const std::vector<Sight>& sights);

/// Undistorted points on the normalized plane of every feature.
std::vector<Eigen::Vector2d> normalizedPoints(const FeatureSet& features,
                                              const CameraModel& camera);

/// Distance on the normalized plane between a world point and a sight; infinite behind the camera.
double reprojectionError(const Sight& sight, const Eigen::Vector3d& p_world);

}  // namespace cf
