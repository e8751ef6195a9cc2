// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "cf/base/time.h"
#include "cf/types/pose_table.h"

namespace cf {

/// How well the final pose of a photo is known.
struct PoseCovarianceRow {
  std::string image;
  TimeNs time = 0;
  int component = 0;  ///< photos joined by matches share one
  PoseCovariance covariance;
};

/// trajectories/<uav>.covariance.csv: image, t, component, then the upper triangles of both
/// covariances row by row, world_tx_tx, world_tx_ty, … world_rz_rz, map_tx_tx, … map_rz_rz:
/// translation [m] and rotation vector [rad], in the world's axes.
void writePoseCovariances(const std::filesystem::path& file,
                          const std::vector<PoseCovarianceRow>& rows);
/// Throws RunError where it cannot be understood.
std::vector<PoseCovarianceRow> readPoseCovariances(const std::filesystem::path& file);

}  // namespace cf
