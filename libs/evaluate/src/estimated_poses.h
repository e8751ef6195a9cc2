// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "cf/base/time.h"
#include "cf/types/pose_table.h"

namespace cf {

/// A posed photo of a run.
struct EstimatedPose {
  std::string uav;
  TimeNs time = 0;
  Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
  std::optional<PoseCovariance> covariance;
  int component = 0;
};
/// By photo name, which several UAVs may use.
using EstimatedPoses = std::multimap<std::string, EstimatedPose>;

/// Component and covariance by photo name and time.
using PoseCovariances = std::map<std::pair<std::string, TimeNs>, std::pair<int, PoseCovariance>>;

/// The covariances beside trajectories/<uav>.tum; none if there is no such file.
PoseCovariances readCovariances(std::filesystem::path tum);

/// images/<uav>.csv and trajectories/<uav>.tum of all UAVs, with covariances where there are any.
/// Throws RunError where there are none or the two do not agree.
EstimatedPoses readEstimatedPoses(const std::filesystem::path& out_dir);

}  // namespace cf
