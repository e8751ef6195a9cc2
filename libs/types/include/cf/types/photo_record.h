// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <string>

#include "cf/base/time.h"

namespace cf {

/// What became of one photo.
enum class PhotoStatus {
  kPosed,     ///< has a final pose
  kUnposed,   ///< could not be tracked
  kUnjoined,  ///< tracked, but in a part of the flight that nothing ties to the map
  kDamaged    ///< could not be decoded
};

struct PhotoRecord {
  std::string name;  ///< original base name with extension
  TimeNs time = 0;
  PhotoStatus status = PhotoStatus::kUnposed;
  int segment = -1;  ///< -1: none
  int keypoints = 0;
  int matches = 0;
  int inliers = 0;
  std::string reason;  ///< why it has no pose; empty if posed
};

struct PhotoPose {
  std::uint32_t photo = 0;                                        ///< index among its UAV's photos
  Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();  ///< metres
};

/// The scale of one segment as estimated at one time.
struct ScaleRow {
  TimeNs t = 0;
  int segment = 0;
  double scale = 1;  ///< metres per VO unit
  double sigma = 0;
};

}  // namespace cf
