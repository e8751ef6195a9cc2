// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <opencv2/core/types.hpp>
#include <vector>

namespace cf {

/// Delaunay triangulation by divide and conquer on quad-edges (Guibas and Stolfi 1985), exact for
/// coordinates from 0 to 2^14. `points` must be sorted by x, then y, and differ. Triangles are
/// indices into `points`; none where all points are on one line.
std::vector<std::array<int, 3>> delaunayTriangles(const std::vector<cv::Point>& points);

}  // namespace cf
