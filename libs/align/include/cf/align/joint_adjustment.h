// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cf/align/match_graph.h"
#include "cf/align/photo_source.h"
#include "cf/base/options.h"
#include "cf/types/pose_table.h"

namespace cf {

struct JointOptions {
  int points_per_photo = 300;     ///< aimed at in the adjustment, of either kind, spread out
  double feature_sigma_px = 0.7;  ///< of a feature until it is measured, at the feature size
  /// What the features of a part of a photo have in common (rolling shutter, lens, moving leaves)
  /// does not average out: its measured variance counts so many times in an observation's own
  /// against the priors and GNSS.
  double common_error_reach = 20000;
  double principal_point_sigma = 0.001;  ///< prior, of the photo's width
  double focal_deviation = 0.005;        ///< relative; between UAVs with the same camera model
  double bias_sigma_horizontal_m = 3;    ///< prior of a UAV's GNSS bias
  double bias_sigma_vertical_m = 10;
  std::string camera = "per_uav";  ///< or shared, among UAVs given the same camera
  bool refine_cameras = true;
  int max_iterations = 25;

  void visit(OptionVisitor& v);
};

/// One photo in the joint adjustment.
struct JointPhoto {
  FrameId id;
  Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
  std::optional<GnssPosition> fix;  ///< sigma as estimated for its UAV
  bool held = false;                ///< sees points, but stays where it is
};

struct JointProblem {
  std::vector<JointPhoto> photos;    ///< all of one component
  std::vector<CameraModel> cameras;  ///< by UAV
  double median_depth_m = 0;         ///< for the scale of the weak priors
  bool cameras_held = false;
  /// For a map that a later one replaces: fewer points, detections alone, no covariances; a tenth
  /// of the time.
  bool draft = false;
  /// Where points seen from several strips or UAVs are aligned by grey values; without it their
  /// detections have to do.
  PhotoSource source;
};

struct JointSolution {
  std::map<FrameId, Eigen::Isometry3d> T_world_cam;  ///< held ones too
  std::map<FrameId, PoseCovariance> covariance;      ///< no entry where it is not determined
  std::vector<CameraModel> cameras;                  ///< by UAV, with sigmas after
  std::map<std::uint16_t, Eigen::Vector3d> bias_m;   ///< GNSS minus map, by UAV
  std::vector<SparsePoint> points;                   ///< every track that triangulates well
  double reprojection_rms_px = 0;  ///< of the points' observations, at the feature size
};

/// One bundle adjustment over all UAVs: tracks that cross UAVs, strips and segments; poses, points,
/// lens (focal length, principal point, k1, k2, p1, p2) of each camera under its priors, a GNSS
/// bias per UAV. Weak priors on the poses given hold what nothing else does (roll about a straight
/// flight). Beyond the paper; replaces its equation (9) where the data allow it. Deterministic.
JointSolution adjustJointly(const MatchGraph& graph, const std::vector<Track>& tracks,
                            const JointProblem& problem, const JointOptions& options);

}  // namespace cf
