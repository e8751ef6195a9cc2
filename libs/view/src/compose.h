// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

#include "cf/view/view_camera.h"

namespace cf {

/// One rendered layer: colour (CV_8UC3 BGR) and depth along the view (CV_32FC1, metres; 0 = none).
struct Layer {
  cv::Mat colour, depth;
};

/// Fills gaps between points that are surrounded by points, a pixel from each side at a time.
void closeGaps(Layer& layer, int rounds);

/// Unsharp masking of the depth buffer (Luft, Colditz, Deussen 2006): darkens what lies behind its
/// surroundings, so that relief is seen without surface normals; even slopes stay as they are.
/// `reach_px`: size of the surroundings; steps below `ignore_px` pixels in depth are left alone
/// (the flat splats of a point cloud make such). Works on every `step`-th pixel and shades blocks
/// of that size.
void shadeRelief(Layer& layer, const ViewCamera& camera, double reach_px, double ignore_px,
                 int step);

/// Lays the lines over the surface: dimmed where the surface hides them, with a dark rim.
void layOver(Layer& surface, const Layer& lines, int rim_px);

}  // namespace cf
