// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "cf/align/match_graph.h"
#include "cf/types/pose_table.h"

namespace cf {

/// Points for an adjustment, spread over the photos: those that cross UAVs before others, then
/// those seen most often, until the cells of a grid over each photo have their share of
/// `points_per_photo`.
std::vector<SparsePoint> choosePoints(const MatchGraph& graph,
                                      const std::vector<SparsePoint>& points, int points_per_photo);

}  // namespace cf
