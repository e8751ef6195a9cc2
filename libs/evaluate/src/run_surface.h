// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <string>

#include "height_grid.h"

namespace cf {

/// The surface model of a run in the grid of its UTM zone, and how well each cell is known.
struct RunSurface {
  HeightGrid heights;
  /// [m^2] of the cell's height as fusion tells it, up to a factor: the inverse of the confidence
  /// of the cloud's points there, mean over 3 x 3 cells. CV_32FC1; NaN where too few views saw the
  /// surface (holes that the surface model bridges among them).
  cv::Mat variance;
  /// [m] what surfaces that bend do to the height, CV_32FC1. On slopes an eighth of the range over
  /// 5 x 5 cells (a place off by half a cell), and half of what the height differs by from the mean
  /// of those four cells to both sides, in the direction where that is most (matching rounds
  /// ridges off). Beside an edge half that range. Less, squared, what is usual in this surface: its
  /// noise.
  cv::Mat step;
  cv::Mat edge;  ///< CV_8UC1: 1 where an edge is near: heights differ as on slopes above 45 degrees
  std::string crs, height_datum;

  double west() const { return heights.west_m; }
  double north() const { return heights.north_m; }
  double cell() const { return heights.spacing_m; }
};

/// From dsm.tif and cloud/tiles.json; points that fewer than `min_views` depth frames saw do not
/// measure. Throws RunError where a file is missing or the run is a relative map.
RunSurface readRunSurface(const std::filesystem::path& out_dir, int min_views);
/// Means over as many cells as fit into `cell_m`.
RunSurface averaged(const RunSurface& surface, double cell_m);

}  // namespace cf
