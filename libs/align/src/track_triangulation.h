// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <map>
#include <vector>

#include "cf/align/match_graph.h"
#include "cf/types/camera_model.h"
#include "cf/types/pose_table.h"

namespace cf {

struct PosedPhoto {
  Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
  CameraModel camera;
};

/// Triangulates every track from those of its photos that have a pose. Observations worse than
/// `threshold_px` (at the feature size) are left out one by one, the worst first; tracks that keep
/// fewer than two, or too small an angle, give no point. In the order of the tracks, whatever the
/// number of threads.
std::vector<SparsePoint> triangulateTracks(const MatchGraph& graph,
                                           const std::vector<Track>& tracks,
                                           const std::map<FrameId, PosedPhoto>& photos,
                                           double threshold_px);

/// Root mean square over all observations of the points, pixels at the feature size.
double reprojectionRmsPx(const MatchGraph& graph, const std::vector<SparsePoint>& points,
                         const std::map<FrameId, PosedPhoto>& photos);

}  // namespace cf
