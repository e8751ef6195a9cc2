// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "cf/align/joint_adjustment.h"
#include "cf/align/match_graph.h"
#include "cf/types/pose_table.h"
#include "cf/types/sim3.h"

namespace cf {

/// The map between two solves of the whole.
struct GrowingMap {
  PoseTable table;
  std::map<FrameId, double> scales;  ///< of photos in the table: metres per VO unit there
};

/// From the local frame of a segment of a UAV to the map, at the newest of its photos up to `id`
/// that are in the map; none where there is none.
std::optional<Sim3> similarityInMap(const MatchGraph& graph, const GrowingMap& map, FrameId id,
                                    int segment);

/// Takes `fresh` photos into the map, each carried on by its odometry from the newest photo of its
/// segment that is in the map. Returns them; photos of a segment that has none in the map are left
/// out. In order of `fresh`.
std::vector<FrameId> carryOn(const MatchGraph& graph, const std::vector<FrameId>& fresh,
                             GrowingMap& map);

/// Adjusts the photos carried on and those that match them best; others that they match, and the
/// cameras, are held. The cost depends on the number of these photos, not on the size of the map.
void adjustAround(const MatchGraph& graph, const std::vector<FrameId>& carried,
                  const JointOptions& options, GrowingMap& map);

/// The range of depths of every photo as the points have it; photos that see none keep theirs.
void setDepths(const std::vector<SparsePoint>& points, PoseTable& table);

}  // namespace cf
