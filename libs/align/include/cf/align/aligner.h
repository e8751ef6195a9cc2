// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "cf/align/candidates.h"
#include "cf/align/joint_adjustment.h"
#include "cf/align/match_graph.h"
#include "cf/align/pair_observation.h"
#include "cf/align/relative_pose_optimisation.h"
#include "cf/align/segment_joining.h"
#include "cf/base/options.h"
#include "cf/types/pose_table.h"

namespace cf {

struct AlignOptions {
  std::string method = "joint";  ///< homography: the paper's relative poses alone
  CandidateOptions candidates;
  PairOptions pair;
  JointOptions joint;
  RelativePoseOptions relative;  ///< its bias sigmas are those of `joint`

  void visit(OptionVisitor& v);
};

/// What the central node knows of all UAVs together.
struct Alignment {
  PoseTable table;
  std::vector<SparsePoint> points;
  std::vector<RelativePose> relative_poses;  ///< between UAVs
  std::map<std::uint16_t, Eigen::Vector3d> gnss_bias_m;
  int components = 0;
  bool relative = false;           ///< no georeference at all
  double reprojection_rms_px = 0;  ///< at the feature size
};

/// The central node's alignment of all UAVs, by `method`:
/// - joint: segments are joined (segment_joining.h), then one bundle adjustment over all photos
///   (joint_adjustment.h) moves poses, points and cameras.
/// - homography: the paper's relative poses, equations (7)-(9), move each segment as a whole
///   (relative_pose_optimisation.h); cameras stay, points are triangulated from the result.
/// Either way the strongest relative poses between UAVs are observed and reported. Keyframes are
/// collected; solve() may be called at any time, each time with the newest georeference, and
/// repeats no matching.
class Aligner {
 public:
  Aligner(const AlignOptions& options, std::uint16_t center);
  ~Aligner();

  void push(const GeoKeyframe& keyframe);
  /// `segments` of all UAVs; `quality` and `cameras` by UAV.
  Alignment solve(const std::vector<GeoSegment>& segments, const std::vector<GnssQuality>& quality,
                  const std::vector<CameraModel>& cameras);

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace cf
