// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <vector>

#include "cf/align/match_graph.h"
#include "cf/types/keyframe.h"
#include "cf/types/sim3.h"

namespace cf {

/// Where a photo stands before the joint adjustment.
struct PlacedPhoto {
  Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
  double scale = 1;  ///< metres per VO unit of its own inverse depths, here
  int component = 0;
};

struct Placement {
  std::map<FrameId, PlacedPhoto> photos;  ///< photos that could not be placed are absent
  int components = 0;
  bool relative = false;  ///< nothing is georeferenced: the world is the largest segment's frame
};

/// Joins segments through the triangulated features that their photos share: a robust Sim3 for
/// each pair of segments, kept if the photos then agree all over the ground that they would share
/// (things that look alike agree in a patch of it), a maximum spanning forest of them, and each
/// tree brought back to the world by the georeferenced poses of its segments, all of them weighed
/// together. Photos alone in their segment are resected against the points that their matches see.
/// Segments that nothing joins keep their georeferenced poses as components of their own; those
/// without georeference are left out. Component 0 holds most photos of UAV `center`.
Placement joinSegments(const MatchGraph& graph, const std::vector<GeoSegment>& segments,
                       std::uint16_t center);

}  // namespace cf
