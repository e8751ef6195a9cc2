// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>

namespace cf {

/// A north-up raster: pixel (column, row) covers [left + column cell, left + (column + 1) cell) x
/// (top - (row + 1) cell, top - row cell].
struct GeoTiffGrid {
  int width = 0, height = 0;     ///< [px]
  double left_m = 0, top_m = 0;  ///< outer corner of the first pixel
  double cell_m = 1;
  std::string crs;  ///< "EPSG:32617" or WKT; empty: none
};

/// Writes a large GeoTIFF window by window: tiled and compressed, with internal overviews (each
/// half of the one before, averaged). Either heights (one band of Float32, deflated, no-data
/// -9999) or colours (red, green, blue, JPEG at quality 92, with an internal mask). Windows never
/// written hold no data and take no room. The file appears under its name at close(). Throws
/// RunError naming the path.
class GeoTiffWriter {
 public:
  enum class Kind { kHeights, kColours };
  static constexpr float kNoHeight = -9999;
  static constexpr int kTile_px = 512;

  GeoTiffWriter(const std::filesystem::path& path, Kind kind, const GeoTiffGrid& grid,
                const std::map<std::string, std::string>& metadata);
  ~GeoTiffWriter();
  GeoTiffWriter(const GeoTiffWriter&) = delete;
  GeoTiffWriter& operator=(const GeoTiffWriter&) = delete;

  /// The window at (column, row): CV_32FC1 heights, NaN for none; or CV_8UC4 BGR and 0 or 255
  /// whether there is anything. Compresses best where windows begin and end at multiples of
  /// kTile_px.
  void write(int column, int row, const cv::Mat& window);
  void close();

 private:
  struct Handle;
  std::filesystem::path path_, temporary_;
  Kind kind_;
  std::unique_ptr<Handle> handle_;
};

/// Reads windows of a raster of heights.
class GeoTiffReader {
 public:
  explicit GeoTiffReader(const std::filesystem::path& path);
  ~GeoTiffReader();
  GeoTiffReader(const GeoTiffReader&) = delete;
  GeoTiffReader& operator=(const GeoTiffReader&) = delete;

  const GeoTiffGrid& grid() const { return grid_; }
  /// CV_32FC1, NaN where there is no height or the window leaves the raster. Not thread-safe.
  cv::Mat heights(const cv::Rect& window) const;

 private:
  struct Handle;
  std::filesystem::path path_;
  std::unique_ptr<Handle> handle_;
  GeoTiffGrid grid_;
};

}  // namespace cf
