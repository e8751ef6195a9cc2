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

/// Noise of the receiver per axis (ENU), in tagged sigmas.
struct Noise {
  Eigen::Vector3d factor = Eigen::Vector3d::Ones();  ///< of one fix
  /// How much wider fixes must be weighed because their errors follow one another:
  /// sqrt((1 + r) / (1 - r)) with r the correlation of neighbours; 1 for white noise.
  Eigen::Vector3d colour = Eigen::Vector3d::Ones();

  Eigen::Vector3d weighed() const { return factor.cwiseProduct(colour); }
};

/// Sums over fixes from which it is estimated, per axis, of errors in tagged sigmas.
struct NoiseSums {
  Eigen::Vector3d square = Eigen::Vector3d::Zero();    ///< expected squares, for the factor
  Eigen::Vector3d count = Eigen::Vector3d::Zero();     ///< of fixes
  Eigen::Vector3d residual = Eigen::Vector3d::Zero();  ///< squared residuals of neighbouring pairs
  Eigen::Vector3d lagged = Eigen::Vector3d::Zero();    ///< their products
  Eigen::Vector3d pairs = Eigen::Vector3d::Zero();

  NoiseSums& operator+=(const NoiseSums& o);
};
/// Posterior mean of the variance under a prior worth `prior_dof` fixes at the tagged sigma.
Noise noiseOf(const NoiseSums& sums, double prior_dof);

struct Segment {
  int number = 0;
  std::vector<Node> nodes;
  double scale = 1;
  double log_scale_sigma = 0;
  bool solved = false;
  double longest_step = 0;          ///< of odometry [VO units]
  std::size_t full_solve_size = 0;  ///< keyframes at the last full solve
  bool scale_held = false;          ///< global_fusion: set for good
  NoiseSums noise;

  int fixes() const;
};

/// Metres per VO unit by each photo with a tagged height: that over its median depth.
std::vector<double> scaleHints(const Segment& segment);

/// The plane of a keyframe's triangulated features and their median depth, set in `node`.
void measureGround(Node& node, const GeoreferenceOptions& options);

/// T_i_j of consecutive nodes in the local frame [VO units] and its standard deviations.
struct Increment {
  Eigen::Isometry3d T_i_j;
  double rotation_sigma_rad;
  double translation_sigma;  ///< [VO units]
};
/// Without sigmas.
Eigen::Isometry3d incrementTo(const Segment& segment, std::size_t j);

/// Predicts the last node from the one before: its increment at the segment's scale.
void predictLast(Segment& segment);

/// World poses of all nodes from one rigid similarity of the odometry to the fixes, robust.
/// Returns false without any fix. `segment.noise` is set from the rigid residuals.
bool initialise(Segment& segment, const GeoreferenceOptions& options);

/// Marks fixes that residuals of the current poses call outliers.
void gateFixes(Segment& segment, const Noise& noise);

/// Sets `segment.noise` from the current poses, outliers left out.
void measureNoise(Segment& segment, const Noise& used);

/// Of the receiver, from all segments as last measured.
Noise measuredNoise(const std::vector<Segment>& segments, const GeoreferenceOptions& options);

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

}  // namespace cf
