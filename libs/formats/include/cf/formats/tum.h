// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <vector>

#include "cf/base/time.h"

namespace cf {

/// A line of a TUM trajectory: `t tx ty tz qx qy qz qw`, seconds UTC and metres.
struct TimedPose {
  TimeNs time = 0;
  Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
};

/// In the order of the file; times exact to the digit, quaternions normalized, lines that start
/// with # skipped. Throws RunError naming file and line on anything else.
std::vector<TimedPose> readTum(const std::filesystem::path& path);

/// Times as timeText(), positions to the micrometre, quaternions with qw >= 0.
void writeTum(const std::filesystem::path& path, const std::vector<TimedPose>& poses);

}  // namespace cf
