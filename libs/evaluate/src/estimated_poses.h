// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <map>
#include <string>

#include "cf/base/time.h"

namespace cf {

/// A posed photo of a run.
struct EstimatedPose {
  std::string uav;
  TimeNs time = 0;
  Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
};
/// By photo name, which several UAVs may use.
using EstimatedPoses = std::multimap<std::string, EstimatedPose>;

/// images/<uav>.csv and trajectories/<uav>.tum of all UAVs. Throws RunError where there are none or
/// the two do not agree.
EstimatedPoses readEstimatedPoses(const std::filesystem::path& out_dir);

}  // namespace cf
