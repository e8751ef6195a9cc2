// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cf/geometry/similarity.h"
#include "cf/types/pose_table.h"

namespace cf {

/// A photo's pose in both trajectories, T_world_cam, metres.
struct PosePair {
  std::string uav;
  Eigen::Isometry3d estimate = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d reference = Eigen::Isometry3d::Identity();
  std::optional<PoseCovariance> covariance;  ///< as told of the estimate
  int component = 0;                         ///< with a covariance: poses joined by matches
};

struct PosePairs {
  std::vector<PosePair> pairs;
  int missing = 0;       ///< reference poses that the estimate lacks
  int unreferenced = 0;  ///< estimated poses that the reference lacks
};

/// Joins a run's output (images/<uav>.csv, trajectories/<uav>.tum) with a reference folder
/// (images.tsv: photo, time, …; poses.tum: line k is photo k) by photo name. Where several UAVs
/// have photos of one name, the reference may say `<uav>/<name>`; otherwise the time decides, and
/// what it cannot decide counts as missing. If both folders say their origin in world.json, the
/// estimate is brought into the reference's ENU frame.
PosePairs pairByName(const std::filesystem::path& out_dir, const std::filesystem::path& ref_dir);

/// Joins two TUM files by time: the nearest within 10 ms, each pose once.
PosePairs pairByTime(const std::filesystem::path& estimate, const std::filesystem::path& reference);

/// Errors of the estimate after alignment. Positions [m], rotations [deg].
struct PoseErrors {
  int matched = 0;
  double rmse_m = 0, median_m = 0, max_m = 0;
  Eigen::Vector3d rmse_axis_m = Eigen::Vector3d::Zero();  ///< reference's x, y, z
  double rotation_rmse_deg = 0, rotation_median_deg = 0;
};

struct TrajectoryEvaluation {
  std::vector<PosePair> pairs;
  PoseErrors all;
  std::map<std::string, PoseErrors> per_uav;  ///< under the alignment of all
  int missing = 0;
  int unreferenced = 0;
  Sim3 S_ref_est;       ///< the alignment
  double extent_m = 0;  ///< diagonal of the bounding box of the matched reference positions
};

/// One alignment (none: nullopt) of all UAVs together onto the reference, then the errors. Throws
/// RunError where nothing matches or the alignment is not determined.
TrajectoryEvaluation evaluateTrajectory(const PosePairs& pairs,
                                        std::optional<AlignmentModel> align);

/// One JSON object, lengths in metres and angles in degrees as the keys say.
std::string toJson(const TrajectoryEvaluation& evaluation, const std::string& align);

}  // namespace cf
