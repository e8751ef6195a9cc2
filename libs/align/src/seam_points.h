// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <vector>

#include "cf/align/match_graph.h"
#include "cf/types/seam_point.h"
#include "track_triangulation.h"

namespace cf {

/// Points of tracks that two UAVs see from two photos each or more, triangulated by each UAV alone,
/// whatever the disagreement: a track counts by its matches, not by how well it fits the map, so
/// that a map whose UAVs disagree shows it. Wrong matches are among them; use robust means. Of a
/// track that more UAVs see, every pair. In the order of the tracks.
std::vector<SeamPoint> seamPoints(const MatchGraph& graph, const std::vector<Track>& tracks,
                                  const std::map<FrameId, PosedPhoto>& photos);

}  // namespace cf
