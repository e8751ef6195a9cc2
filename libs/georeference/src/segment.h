// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <vector>

#include "cf/georeference/georeferencer.h"

namespace cf {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

inline constexpr double kRadPerDeg = 0.017453292519943295;

/// What one keyframe contributes to the graph, and its current estimate.
struct Node {
  std::shared_ptr<const Keyframe> keyframe;
  std::optional<GnssPosition> fix;
  std::optional<Eigen::Vector3d> ground_normal_cam;  ///< unit, towards the camera
  double ground_sigma_rad = 0;
  double median_depth = 0;  ///< of triangulated features [VO units]; 0 = unknown

  Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Zero();
  bool horizontal_outlier = false, vertical_outlier = false;
};

/// Sums over fixes from which the noise of the receiver is estimated, per axis (ENU).
struct NoiseSums {
  Eigen::Vector3d square = Eigen::Vector3d::Zero();  ///< of errors in tagged sigmas
  Eigen::Vector3d count = Eigen::Vector3d::Zero();
};

struct Segment {
  int number = 0;
  std::vector<Node> nodes;
  double scale = 1;
  double log_scale_sigma = 0;
  bool solved = false;
  std::size_t full_solve_size = 0;  ///< keyframes at the last full solve
  NoiseSums noise;

  int fixes() const;
};

/// The plane of a keyframe's triangulated features and their median depth, set in `node`.
void measureGround(Node& node, const GeoreferenceOptions& options);

/// T_i_j of consecutive nodes in the local frame [VO units] and its standard deviations.
struct Increment {
  Eigen::Isometry3d T_i_j;
  double rotation_sigma_rad;
  double translation_sigma;  ///< [VO units]
};
Increment incrementTo(const Segment& segment, std::size_t j, const GeoreferenceOptions& options);

/// World poses of all nodes from one rigid similarity of the odometry to the fixes, robust.
/// Returns false without any fix. `segment.noise` is set from the rigid residuals.
bool initialise(Segment& segment, const GeoreferenceOptions& options);

/// Marks fixes that residuals of the current poses call outliers; `factor`: noise in tagged sigmas.
void gateFixes(Segment& segment, const Eigen::Vector3d& factor);

/// Minimises residuals (5), (6) and the attitude priors over nodes from `first_free` on, and over
/// the scale if that is 0; then sets covariances and `segment.noise` of all nodes.
void solve(Segment& segment, const Eigen::Vector3d& factor, const GeoreferenceOptions& options,
           std::size_t first_free, int max_iterations);

/// Exact marginal covariances of a chain with one border variable. The information matrix is block
/// tridiagonal (diagonal[i]; upper[i] between i and i+1) with the border column and corner.
struct ChainInformation {
  std::vector<Matrix6d> diagonal, upper;
  std::vector<Eigen::Matrix<double, 6, 1>> border;
  double corner = 0;
};
struct ChainCovariance {
  std::vector<Matrix6d> diagonal;
  double corner = 0;
};
ChainCovariance marginals(const ChainInformation& information);

/// MRPT text of the graph of all segments.
std::string poseGraphText(const std::vector<Segment>& segments,
                          const std::vector<GeoSegment>& published, const Eigen::Vector3d& factor,
                          const GeoreferenceOptions& options);

}  // namespace cf
