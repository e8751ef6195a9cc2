// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <map>
#include <vector>

#include "cf/types/sim3.h"
#include "run_section.h"
#include "truth_views.h"

namespace cf {

/// A place on the true ground, and where each UAV alone maps it.
struct GroundPoint {
  Eigen::Vector3d truth = Eigen::Vector3d::Zero();
  double gsd_m = 0;                               ///< size of a pixel of the photos there
  std::map<std::size_t, Eigen::Vector3d> mapped;  ///< by UAV, after the cluster's similarity
};

/// Places from an even sample of the true depth maps. The pixels are those of the true cameras and
/// poses, so no feature nor disparity has a part in it; each UAV triangulates them with the
/// estimated cameras and poses from the two of its photos that see the place at the widest angle up
/// to 60 degrees. Places that no UAV can map are left out.
std::vector<GroundPoint> mapGroundPoints(const RunInputs& run, const std::vector<TruthView>& views,
                                         const Sim3& S_ref_est);

/// Between UAVs: the distance of the same place mapped by two of them.
RunSection seamFigures(const RunInputs& run, const std::vector<GroundPoint>& points);

/// Of the mapped places against the truth.
RunSection groundFigures(const RunInputs& run, const std::vector<GroundPoint>& points);

RunSection domingFigures(const std::vector<GroundPoint>& points);

}  // namespace cf
