// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <vector>

#include "cf/align/relative_pose_optimisation.h"
#include "cf/align/segment_joining.h"
#include "relative_poses.h"

namespace cf {

struct HomographyPlacement {
  Placement placement;
  std::map<std::uint16_t, Eigen::Vector3d> gnss_bias_m;  ///< GNSS minus map
};

/// The paper's third optimisation, equations (7)-(9): one similarity for each segment from the
/// relative poses between segments; segments stay rigid and cameras as they are. Photos that no
/// relative pose places, and every photo where nothing is georeferenced, are placed as
/// joinSegments places them.
HomographyPlacement placeByRelativePoses(const MatchGraph& graph,
                                         const std::vector<GeoSegment>& segments,
                                         const std::map<FrameId, GnssPosition>& fixes,
                                         const std::vector<PairObservation>& observations,
                                         std::uint16_t center, const RelativePoseOptions& options);

}  // namespace cf
