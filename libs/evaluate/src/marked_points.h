// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <string>
#include <vector>

#include "cf/base/result.h"
#include "cf/evaluate/ground_control.h"
#include "cf/formats/gcp_list.h"
#include "cf/types/camera_model.h"

namespace cf {

/// A mark in a photo with a pose.
struct MarkedSight {
  std::string uav, image;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< as marked
  Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
  CameraModel camera;  ///< for photos of the size in which it was marked

  /// Where the camera sees the point, minus the mark [px].
  Eigen::Vector2d errorOf(const Eigen::Vector3d& p_world) const;
};

struct MarkedPoint {
  std::string name;
  Eigen::Vector3d surveyed = Eigen::Vector3d::Zero();  ///< ENU of the run's world [m]
  std::vector<MarkedSight> sights;
  std::vector<std::string> without_pose;  ///< photos with a mark, but no pose in the run

  int uavs() const;
};

/// The list's points, in the run's world, with the run's poses and refined cameras. Throws RunError
/// where the run's files are not there or a mark does not fit its photo, UsageError where the list
/// has an unknown CRS, a position that is no place, or a photo's name that several UAVs have.
std::vector<MarkedPoint> joinMarks(const std::filesystem::path& out_dir, const GcpList& list,
                                   std::optional<PhotoSize> size);

struct MarkedPlace {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< world
  double max_angle_rad = 0;                            ///< largest between two rays
};

/// The place of the least sum of squared pixel errors; fails as triangulate() does.
Result<MarkedPlace> placeOf(const std::vector<MarkedSight>& sights);

}  // namespace cf
