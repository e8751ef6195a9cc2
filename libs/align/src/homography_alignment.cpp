// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "homography_alignment.h"

#include <algorithm>
#include <set>
#include <utility>

namespace cf {
namespace {

std::vector<SegmentInput> inputsOf(const std::vector<GeoSegment>& segments,
                                   const std::map<FrameId, GnssPosition>& fixes) {
  std::vector<SegmentInput> inputs;
  for (const GeoSegment& segment : segments) {
    SegmentInput input{segment, {}};
    for (const auto& pose : segment.poses) {
      const auto fix = fixes.find(pose.frame);
      input.fixes.push_back(fix != fixes.end() ? std::optional(fix->second) : std::nullopt);
    }
    inputs.push_back(std::move(input));
  }
  return inputs;
}

/// A segment without georeference can only be placed where both photos know depths: what cannot
/// place it is left out.
std::vector<PairObservation> usable(const std::vector<PairObservation>& observations,
                                    const std::vector<GeoSegment>& segments) {
  std::set<FrameId> located;
  for (const GeoSegment& segment : segments)
    for (const auto& pose : segment.poses)
      if (segment.georeferenced) located.insert(pose.frame);
  std::vector<PairObservation> kept;
  for (const PairObservation& o : observations) {
    const bool both_located = located.count(o.pose.a) > 0 && located.count(o.pose.b) > 0;
    const bool both_depths = o.by_depth_a.sigma_m > 0 && o.by_depth_b.sigma_m > 0;
    if (both_located || both_depths) kept.push_back(o);
  }
  return kept;
}

/// The segments as the solution moves them; what it brings into the world is georeferenced.
std::vector<GeoSegment> correctedSegments(const std::vector<GeoSegment>& segments,
                                          const RelativePoseSolution& solution) {
  std::set<int> located;
  for (std::size_t s = 0; s < segments.size(); ++s)
    if (segments[s].georeferenced) located.insert(solution.corrections[s].component);
  std::vector<GeoSegment> corrected = segments;
  for (std::size_t s = 0; s < segments.size(); ++s) {
    const SegmentCorrection& c = solution.corrections[s];
    GeoSegment& segment = corrected[s];
    if (!c.connected || located.count(c.component) == 0) continue;
    for (auto& pose : segment.poses) pose.T_world_cam = c.S_world_before.carry(pose.T_world_cam);
    segment.scale = c.S_world_before.scale * (segment.georeferenced ? segment.scale : 1);
    segment.georeferenced = true;
  }
  return corrected;
}

}  // namespace

HomographyPlacement placeByRelativePoses(const MatchGraph& graph,
                                         const std::vector<GeoSegment>& segments,
                                         const std::map<FrameId, GnssPosition>& fixes,
                                         const std::vector<PairObservation>& observations,
                                         std::uint16_t center, const RelativePoseOptions& options) {
  const bool relative = std::none_of(segments.begin(), segments.end(),
                                     [](const GeoSegment& s) { return s.georeferenced; });
  if (relative) return {joinSegments(graph, segments, center), {}};
  const RelativePoseSolution solution = optimiseRelativePoses(
      inputsOf(segments, fixes), usable(observations, segments), center, options);
  const std::vector<GeoSegment> corrected = correctedSegments(segments, solution);
  HomographyPlacement out{joinSegments(graph, corrected, center), solution.bias_m};
  for (const GeoSegment& segment : corrected) {
    if (!segment.georeferenced) continue;
    for (const auto& pose : segment.poses) {
      const auto placed = out.placement.photos.find(pose.frame);
      if (placed == out.placement.photos.end()) continue;
      placed->second.T_world_cam = pose.T_world_cam;
      placed->second.scale = segment.scale;
    }
  }
  return out;
}

}  // namespace cf
