// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "cf/densify/densify.h"
#include "cf/types/tile.h"

namespace cf {

/// The map so far from above, north up, BGR: the uppermost points of the tiles in their colours,
/// each UAV's track in its colour with a triangle at its end. At most 2000 pixels a side. Empty
/// where there is nothing to show. `views` in the order in which they were taken.
cv::Mat liveMapPicture(const std::vector<Tile>& tiles, double voxel_m,
                       const std::vector<DenseView>& views, std::uint16_t central_uav);

/// How many photos see each place of the ground, which is taken to be level below each photo: red
/// one, orange two, yellow three, green from five on; fewer than three give no sound surface. North
/// up, with tracks and a legend.
cv::Mat coveragePicture(const std::vector<DenseView>& views, std::uint16_t central_uav);

}  // namespace cf
