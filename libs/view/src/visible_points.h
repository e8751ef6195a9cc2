// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "cf/view/scene_inputs.h"
#include "cf/view/view_camera.h"

namespace cf {

/// What a picture shows of a cloud: one point for each cell of `cell_px` x `cell_px` pixels that
/// has any. It is the nearest of the cell's points, moved into the middle of the cell, with the
/// mean colour of those that lie about as near (within kSurfaceCells cells). Drawing millions of
/// points on top of each other looks no better and takes many times as long.
std::vector<ColouredPoint> visiblePoints(const std::vector<ColouredPoint>& cloud,
                                         const ViewCamera& camera, int cell_px);

inline constexpr double kSurfaceCells = 3;

}  // namespace cf
