// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cf/base/options.h"
#include "cf/types/keyframe.h"

namespace cf {

/// Options of the georeference stage. Standard deviations that describe an error common to a whole
/// segment (attitude tags, nadir, ground) count once per segment, however many photos it has.
struct GeoreferenceOptions {
  std::string method = "two_stage";      ///< or "global_fusion", the baseline
  double vo_rotation_sigma_deg = 0.1;    ///< of one odometry increment
  double vo_step_sigma = 0.01;           ///< of its translation, as a fraction of its length
  double vo_depth_sigma = 0.001;         ///< plus this fraction of the median depth
  double max_gap_s = 5;                  ///< fixes further apart than this are not interpolated
  double acceleration_sigma_mps2 = 0.5;  ///< of the UAV, for the error of interpolated fixes
  int max_wait_keyframes = 5;            ///< a photo waits for its fix that many photos at most
  double prior_dof = 3;                  ///< weight of the tagged sigma, counted in fixes
  double common_error = 1;               ///< error common to all fixes, in tagged sigmas
  double junk_factor = 3;                ///< horizontal noise above this many tagged sigmas …
  double junk_sigma_m = 5;               ///< … and above this is junk
  double gimbal_tilt_sigma_deg = 2;      ///< of tagged pitch and roll
  double gimbal_yaw_sigma_deg = 10;      ///< of tagged yaw
  double nadir_sigma_deg = 15;    ///< camera axis against straight down, without a gimbal tag
  double ground_sigma_deg = 7;    ///< slope of the ground under a segment
  double height_tag_sigma = 0.2;  ///< tagged height against median depth, as a fraction
  double max_scale_sigma = 0.3;   ///< relative; above it a segment stays in its local frame
  double max_yaw_sigma_deg = 30;  ///< the same for its heading
  int full_solve_keyframes = 60;  ///< up to here every photo re-solves its whole segment
  int window_keyframes = 30;      ///< beyond: this many last ones, until grown by a tenth
  double fusion_rotation_sigma_deg = 0.57;  ///< global_fusion: of any increment
  double fusion_step_sigma_m = 0.1;         ///< global_fusion: of any increment
  int fusion_start_fixes = 10;  ///< global_fusion: with so many the scale is set for good

  void visit(OptionVisitor& v);
};

/// A fix as a position in the world frame (ENU, metres).
using FixToWorld = std::function<Eigen::Vector3d(const GnssFix&)>;

/// The scale of one segment as known when one of its keyframes had been processed.
struct ScaleSample {
  TimeNs time = 0;
  int segment = 0;
  double scale = 1;  ///< metres per VO unit
  double sigma = 0;
  bool georeferenced = false;
};

/// Stage 1 of the GNSS optimisation for one UAV: scale and world poses of every segment from
/// odometry increments and fixes, by one of two methods:
/// - two_stage: Eq. (4)-(6) of arXiv 2304.04943, corrected as in docs/method.md; the scale is a
///   state.
/// - global_fusion: the baseline, the global fusion of VINS-Fusion (Qin et al., arXiv 1901.03642),
///   made for metric odometry: here the first fixes bring it to metres once. Its scale is read off
///   the optimised path: its length over the odometry's.
///
/// A keyframe leaves as a GeoKeyframe, in order, as soon as its fix can be interpolated, or after
/// max_wait_keyframes later ones, or at flush(). The noise of the receiver is estimated per axis
/// from the residuals. Deterministic; no threads.
class Georeferencer {
 public:
  /// Throws UsageError on an unknown method.
  Georeferencer(std::uint16_t uav, const GeoreferenceOptions& options, FixToWorld fix_to_world);
  ~Georeferencer();
  Georeferencer(Georeferencer&&) noexcept;
  Georeferencer& operator=(Georeferencer&&) noexcept;

  /// In any order; of two with the same time the later call counts. A fix for a keyframe that has
  /// left already is not used, nor is one that is not finite or has no sigma.
  void addFix(const GnssFix& fix);
  /// Keyframes in time order.
  std::vector<GeoKeyframe> push(std::shared_ptr<const Keyframe> keyframe);
  /// Releases the waiting keyframes and solves every segment in full.
  std::vector<GeoKeyframe> flush();

  /// Current estimate of every keyframe that has left, by segment number.
  const std::vector<GeoSegment>& segments() const;
  /// Of the receiver, from all fixes used so far; its bias is not known to one UAV alone.
  GnssQuality quality() const;
  /// One sample for each keyframe that has left.
  const std::vector<ScaleSample>& scaleHistory() const;
  /// The pose graph in MRPT's text format (CNetworkOfPoses3DInf): node 0 is the world, node i + 1
  /// is photo i; edges are odometry increments in metres, fixes and attitudes.
  std::string graphText() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cf
