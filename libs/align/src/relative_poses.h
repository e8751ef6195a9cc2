// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "cf/align/match_graph.h"
#include "cf/align/pair_observation.h"
#include "cf/types/gnss_fix.h"
#include "cf/types/keyframe.h"
#include "cf/types/pose_table.h"

namespace cf {

/// Photos as their UAVs know them alone.
using PairViews = std::map<FrameId, PairView>;

/// Pairs that were tried; empty where the relative pose could not be observed.
using PairObservations = std::map<MatchGraph::Pair, std::optional<PairObservation>>;

/// Observes the relative poses of photos of different segments: for each photo, of its matched
/// partners in each other segment, the two with the most matches. Sorted by (a, b). What is in
/// `known` is not observed again.
std::vector<PairObservation> observeStrongestPairs(const MatchGraph& graph, const PairViews& views,
                                                   const PairOptions& options,
                                                   PairObservations& known);

/// Metres per VO unit of each photo's own inverse depths, as the points of the map have them.
/// Photos that see no such point are absent.
std::map<FrameId, double> scalesInMap(const MatchGraph& graph, const PoseTable& table,
                                      const std::vector<SparsePoint>& points);

/// The observation with its length in the metres of the map (`scale_a`, `scale_b`: metres per VO
/// unit there), and its residuals against the poses before and after.
RelativePose relativePoseInMap(const PairObservation& observation, const PairViews& before,
                               const PoseTable& after, double scale_a, double scale_b);

}  // namespace cf
