// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <vector>

#include "cf/align/match_graph.h"
#include "cf/align/photo_source.h"
#include "cf/types/pose_table.h"
#include "track_triangulation.h"

namespace cf {

/// What holds strips and UAVs together, to the precision of what holds a strip together.
struct AlignedLinks {
  MatchGraph graph{MatchGraphOptions{}};  ///< sights where the grey values put them, and no others
  std::vector<Track> tracks;              ///< in `graph`
  std::vector<SparsePoint> left;          ///< of the links given, those that could not be aligned
};

/// Aligns the sights of each link with its first by grey values (features/patch_alignment.h), from
/// where the detections lie and with the warp that poses and points predict. Sights that cannot be
/// aligned are left out, links with none aligned are left. In a fixed order, whatever the number of
/// threads; memory does not grow with the number of photos.
AlignedLinks alignLinks(const MatchGraph& graph, const std::vector<SparsePoint>& links,
                        const std::map<FrameId, PosedPhoto>& photos, const PhotoSource& source);

}  // namespace cf
