// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

namespace cf {

/// A point of the fused cloud over a raster: x and y in cells, counted from the outer corner of
/// the first cell, y down; z the height in cells above any level.
struct SurfacePoint {
  float x = 0, y = 0, z = 0;
  float confidence = 0;
  float views = 0;
};

/// The uppermost surface, CV_32FC1 of `size`, NaN where no point falls into a cell.
///
/// Points of a cell less than four cells apart in height form a surface; the uppermost counts that
/// has a quarter of the views of the best seen one. Its top is the uppermost of its points that has
/// three tenths of its greatest confidence; its height is the mean, weighted by confidence, of the
/// points within three cells below: a wall does not draw the roof down, noise does not lift it.
///
/// Cells are then dropped that have fewer than three companions within two cells of height among
/// the 24 around, or fewer than eight, outnumbered by others that were seen twice as often. The rest
/// is smoothed over 3 x 3 cells, those apart by more than three cells of height left out, so that
/// edges stay.
cv::Mat uppermostSurface(const std::vector<SurfacePoint>& points, cv::Size size);

/// Gives height to cells without, where they are surrounded: in at least six of eight directions a
/// height is within `reach` cells. Where those heights differ by more than `step`, the lower ones
/// count: what photos from above cannot see lies beside a roof, not on it. Weights fall with the
/// distance squared. Heights that are there are not changed.
cv::Mat withHolesFilled(const cv::Mat& heights, int reach, float step);

}  // namespace cf
