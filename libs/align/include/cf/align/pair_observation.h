// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "cf/base/options.h"
#include "cf/base/result.h"
#include "cf/types/keyframe.h"
#include "cf/types/pose_table.h"

namespace cf {

/// How the relative pose of two photos is observed.
struct PairOptions {
  double threshold = 2e-3;  ///< inlier distance, pixels over focal length
  int min_inliers = 25;
  double min_share = 0.12;    ///< of the matches
  double planar_share = 0.7;  ///< a homography with this part of the epipolar inliers is preferred,
                              ///< as is one with half of the matches
  double max_rotation_deg = 25;  ///< against a trusted attitude
  double prior_sigma_deg = 8;    ///< of a trusted attitude
  /// Error that neighbouring matches share (lens, principal point, rolling shutter), over focal.
  double systematic = 5e-4;

  void visit(OptionVisitor& v);
};

/// One photo of a pair as its segment knows it now.
struct PairView {
  const Keyframe* keyframe = nullptr;
  Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();  ///< metres
  double scale = 1;        ///< metres per VO unit of its segment
  double scale_sigma = 0;  ///< 1-sigma of it
  bool trusted = false;    ///< georeferenced: the pose is in the world, good to prior_sigma_deg
};

enum class PairModel { kHomography, kEssential };
const char* name(PairModel model);

/// Length of the translation by the depths of one photo.
struct DepthLength {
  double length_m = 0;  ///< with the metres of its own segment's scale
  double sigma_m = 0;   ///< without that of the scale; 0 = this photo has too few depths
};

struct PairObservation {
  /// In metres; the length is the weighted mean of the two below. Its residuals are not set.
  RelativePose pose;
  PairModel model = PairModel::kHomography;
  int segment_a = 0, segment_b = 0;
  Eigen::Vector3d direction_a = Eigen::Vector3d::UnitX();  ///< unit, from a to b, in a
  double across_sigma_m = 0;      ///< of the translation, across its direction
  double rotation_sigma_rad = 0;  ///< per axis
  DepthLength by_depth_a, by_depth_b;
  double gnss_length_m = 0;  ///< equation (8): that of the predicted translation; 0 = not trusted
  std::vector<FeatureMatch> inliers;
};

/// Equation (7), as it must read: the pose of b in a that the two world poses predict. Rotation
/// R_world_a' R_world_b, translation R_world_a' (p_b - p_a).
Eigen::Isometry3d predictRelativePose(const Eigen::Isometry3d& T_world_a,
                                      const Eigen::Isometry3d& T_world_b);

/// Observes T_a_b from feature matches. A homography by preference (the scene seen from above is
/// near planar), the essential matrix where that explains much more of them. Which of a
/// homography's solutions holds is told by the plane through the sparse depths and by trusted
/// attitudes. The length of the translation comes from the depths of either photo (the homography's
/// plane distance, or depth over depth); the paper's ratio to the GNSS displacement, equation (8),
/// stands in only where neither has depths.
/// Failures: few_matches, too_few_inliers, low_share, too_little_parallax, no_decomposition,
/// ambiguous, against_prior, no_length.
Result<PairObservation> observePair(const PairView& a, const PairView& b,
                                    const std::vector<FeatureMatch>& matches,
                                    const PairOptions& options);

}  // namespace cf
