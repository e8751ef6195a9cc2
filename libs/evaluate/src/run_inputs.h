// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cf/base/time.h"
#include "cf/types/camera_model.h"
#include "cf/types/pose_table.h"
#include "cf/types/sim3.h"

namespace cf {

/// A photo of the truth, and what a run made of it.
struct RunPhoto {
  std::string name;
  TimeNs time = 0;
  Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();  ///< T_world_cam
  std::optional<Eigen::Isometry3d> estimate;  ///< T_world_cam, in the truth's ENU frame
  std::optional<PoseCovariance> covariance;   ///< of it, as told
  int component = 0;                          ///< with a covariance: photos joined by matches
  int segment = -1;                           ///< -1: none
  std::optional<Eigen::Isometry3d> local;     ///< T_local_cam of the segment, VO units
};

/// A line of scale/<uav>.csv.
struct ScaleEstimate {
  TimeNs time = 0;
  int segment = 0;
  double scale = 1, sigma = 0;  ///< metres per VO unit
};

/// East, north, up [m]; the bias is GNSS minus map.
struct GnssFigures {
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d bias_m = Eigen::Vector3d::Zero();
  int fixes = 0;  ///< 0: not told
};

/// Where a receiver's antenna truly was at a fix that is no outlier.
struct TrueFix {
  TimeNs time = 0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
};

struct RunUav {
  std::string name;
  std::vector<RunPhoto> photos;  ///< all of the truth, in its order
  std::optional<CameraModel> camera_true, camera_before, camera_after;
  std::vector<ScaleEstimate> scale;
  std::optional<GnssFigures> gnss_true, gnss_estimated;
  std::vector<TrueFix> fixes;  ///< in time order; none if the truth does not tell
};

/// A line of relative_poses.csv whose photos the truth knows.
struct RunRelativePose {
  Eigen::Isometry3d estimate = Eigen::Isometry3d::Identity();  ///< T_a_b [m]
  Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
  Eigen::Matrix<double, 6, 1> sigma = Eigen::Matrix<double, 6, 1>::Zero();  ///< t [m], r [rad]
};

/// A run's output folder and the truth of the simulated flight, joined photo by photo.
struct RunInputs {
  std::filesystem::path out_dir, truth_dir;
  std::vector<RunUav> uavs;  ///< by name
  std::vector<RunRelativePose> relative_poses;
  std::optional<double> matched_megapixels;  ///< [densify] megapixels of config.effective.ini
  Eigen::Isometry3d T_ref_est = Eigen::Isometry3d::Identity();  ///< of the two ENU frames
};

/// Photos are joined by UAV and name, those of one name by time. Files that the truth or the run
/// may lack leave their values empty; what is there but cannot be understood throws RunError, and
/// so does a truth without images.tsv and poses.tum, or with no UAV of the run.
RunInputs readRun(const std::filesystem::path& out_dir, const std::filesystem::path& truth_dir);

}  // namespace cf
