// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "cf/align/match_graph.h"

namespace cf {

/// Tracks taken apart by how well their features agree (Keyframe::chain).
struct TrackParts {
  std::vector<Track> chains;  ///< features aligned by grey values: a few hundredths of a pixel
  /// What holds chains together: detections. Of each chain its first and last feature.
  std::vector<Track> links;
  std::vector<Track> detections;  ///< the links with the first feature of each chain alone
};

TrackParts takeApart(const MatchGraph& graph, const std::vector<Track>& tracks);

/// Features of a link that share one detection: 2 if both ends of a chain are in it.
int sharedDetection(const MatchGraph& graph, const Track& link, const SparseObservation& o);

}  // namespace cf
