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

/// Which matched pairs of photos of different segments are observed: those with the most matches.
struct PairSelection {
  std::size_t partners;  ///< of each photo in each other segment
  int choosers;          ///< 1: either photo chose the other; 2: both did
};
/// For the report: few, and one at least for any two segments that match.
inline constexpr PairSelection kMutualBest{1, 2};
/// For an optimisation. More would repeat them: the same landmarks, seen from the next photo of the
/// same rigid segment.
inline constexpr PairSelection kTwoBest{2, 1};

/// Observes the relative poses of the selected pairs, side by side; sorted by (a, b). What is in
/// `known` is not observed again.
std::vector<PairObservation> observePairs(const MatchGraph& graph, const PairViews& views,
                                          PairSelection selection, const PairOptions& options,
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
