// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

namespace cf {

/// A TIFF with one band of Float32: depth maps, surface heights. NaN stands for no value.
struct FloatRaster {
  cv::Mat values;                               ///< CV_32FC1, row 0 at the top
  std::map<std::string, std::string> metadata;  ///< TIFF metadata items, e.g. STEP
  /// GDAL's: x = g[0] + g[1] column + g[2] row, y = g[3] + g[4] column + g[5] row, (0, 0) being
  /// the outer corner of the first pixel.
  std::optional<std::array<double, 6>> geotransform;
  std::string crs_wkt_or_epsg;  ///< WKT or "EPSG:32617"; empty: none
};

/// Tiled, DEFLATE with the floating-point predictor. The file appears whole or not at all. Throws
/// RunError naming the path.
void writeFloatRaster(const std::filesystem::path& path, const FloatRaster& raster);

/// Reads the first band of any TIFF as Float32, its no-data value as NaN; the reference system as
/// "EPSG:…" where it has such a code, otherwise as WKT. Throws RunError naming the path.
FloatRaster readFloatRaster(const std::filesystem::path& path);

}  // namespace cf
