// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <memory>
#include <optional>
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
#include "cf/types/seam_point.h"
#include "cf/types/sim3.h"

namespace cf {

struct AlignOptions {
  std::string method = "joint";  ///< homography: the paper's relative poses alone
  int update_every = 8;  ///< keyframes between versions of the map during the flight; 0: none
  double growth = 1.5;   ///< of the photos since the last solve of the whole, for the next
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
  std::vector<SeamPoint> seam_points;        ///< of matches between UAVs (seam_points.h)
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
/// collected; pairs are matched once, however often the map is brought up to date.
class Aligner {
 public:
  Aligner(const AlignOptions& options, std::uint16_t center);
  ~Aligner();

  void push(const GeoKeyframe& keyframe);
  /// The next version of the map during the flight. Photos new to it are carried on from their
  /// segment, matched, and adjusted with those around them, at a cost that does not grow with the
  /// map (map_extension.h). Each time the map has grown by `growth`, all of it is solved anew, in a
  /// draft: together these cost as much as a few solves of the last. A draft is solved beside the
  /// photos that go on coming and takes effect at the next update, so that what comes out does not
  /// depend on time. Photos that nothing in the map carries on wait for the next draft; that of a
  /// UAV that can join is waited for. `segments` of all UAVs; `quality` and `cameras` by UAV.
  const PoseTable& update(const std::vector<GeoSegment>& segments,
                          const std::vector<GnssQuality>& quality,
                          const std::vector<CameraModel>& cameras);
  /// Whether a UAV, by its segments, knows where it is, and no draft has been made with it since.
  bool canJoin(const std::vector<GeoSegment>& of_uav) const;
  /// From the local frame of a segment of the photo's UAV to the newest version, at the newest
  /// photo of the segment, up to this, that is in it; none where there is none.
  std::optional<Sim3> similarity(FrameId photo, int segment) const;
  /// The whole map from all that has been pushed, whatever earlier versions were like.
  /// With the photos at hand, points are tied across strips by grey values (JointProblem::source).
  Alignment solve(const std::vector<GeoSegment>& segments, const std::vector<GnssQuality>& quality,
                  const std::vector<CameraModel>& cameras, const PhotoSource& source = {});

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace cf
