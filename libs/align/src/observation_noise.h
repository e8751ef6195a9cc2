// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <vector>

#include "cf/align/match_graph.h"
#include "cf/types/pose_table.h"
#include "track_triangulation.h"

namespace cf {

/// How far features lie from where the map projects.
struct ObservationNoise {
  double sigma_px = 0;  ///< of one coordinate, at the feature size
  /// Share of the residuals' variance that features of the same part of a photo have in common. A
  /// perfect camera model leaves none; rolling shutter, in-camera lens correction and moving
  /// leaves leave 0.02 to 0.05 on ordinary drones.
  double common_share = 0;
};

/// Measured from the residuals of all observations of the points; tracks pay for the three
/// coordinates of their point. Zeros without redundant observations.
ObservationNoise measureNoise(const MatchGraph& graph, const std::vector<SparsePoint>& points,
                              const std::map<FrameId, PosedPhoto>& photos);

}  // namespace cf
