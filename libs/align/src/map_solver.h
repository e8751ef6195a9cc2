// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <map>
#include <vector>

#include "cf/align/aligner.h"
#include "relative_poses.h"

namespace cf {

/// What the UAVs know of themselves, each alone.
struct UavKnowledge {
  std::vector<GeoSegment> segments;  ///< of all UAVs
  std::vector<GnssQuality> quality;  ///< by UAV
  std::vector<CameraModel> cameras;  ///< by UAV
};

/// Where a photo is in the map, and metres per VO unit there.
struct Located {
  Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
  double scale = 1;
};

/// All photos at the centre, and the whole map from them. A copy can be solved while photos are
/// pushed to the original.
class MapSolver {
 public:
  MapSolver(const AlignOptions& options, std::uint16_t center);

  void push(const GeoKeyframe& keyframe);
  /// `draft`: for a map that a later one replaces (JointProblem::draft), without relative poses.
  Alignment solve(const UavKnowledge& known, bool draft, std::uint32_t version,
                  const PhotoSource& source);

  const MatchGraph& graph() const { return graph_; }
  /// Matches what has not been tried yet: photos of one UAV that follow each other; pairs. Whether
  /// any of `pairs` became connected.
  void matchNeighbours();
  bool match(const std::vector<MatchGraph::Pair>& pairs) { return graph_.match(pairs); }
  /// Takes over the matches of a copy.
  void learn(const MapSolver& copy) { graph_.learn(copy.graph_); }
  /// Photos that are `located` in the map lie better than GNSS alone can tell.
  std::vector<Footprint> footprints(const UavKnowledge& known,
                                    const std::map<FrameId, Located>& located = {}) const;

 private:
  bool matchCandidates(const std::vector<Footprint>& footprints);
  std::map<FrameId, GnssPosition> weighedFixes(const std::vector<GnssQuality>& quality) const;
  void adjust(const Placement& placement, const UavKnowledge& known, bool draft,
              const PhotoSource& source, Alignment& out) const;
  void keepRigid(const Placement& placement, Alignment& out) const;
  void addPoses(const Placement& placement, Alignment& out) const;
  void addSeamPoints(Alignment& out) const;
  void addRelativePoses(const PairViews& views, const Placement& placement,
                        PairObservations& observed, Alignment& out) const;

  AlignOptions options_;
  std::uint16_t center_;
  MatchGraph graph_;
  std::map<FrameId, GnssPosition> fixes_;
  std::map<FrameId, double> median_depth_;  ///< of each photo's landmarks, VO units
};

}  // namespace cf
