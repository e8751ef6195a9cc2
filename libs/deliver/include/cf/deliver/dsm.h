// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <map>

#include "cf/formats/tile_store.h"
#include "cf/geodesy/grid_frame.h"
#include "cf/types/tile.h"

namespace cf {

/// A digital surface model of the finished cloud: the uppermost surface on a north-up raster in
/// the map's grid (UTM), heights in metres.
///
/// Holes are filled from around where they are surrounded within kHoleReach cells, on the lower
/// side of an edge; larger ones stay without data. Memory: windows of kWindow cells and the tiles
/// under them, two at a time.
class DsmBuilder {
 public:
  static constexpr int kWindow = 1024;
  static constexpr int kHoleReach = 10;

  /// `cell_m` about the side of a voxel; it is rounded down to millimetres.
  DsmBuilder(const GridFrame& grid, double cell_m);

  /// Notes where a tile lies.
  void add(const Tile& tile);
  bool empty() const { return places_.empty(); }
  double cell() const { return cell_m_; }
  /// A GeoTIFF of all tiles noted, which `cloud` must hold. RunError where it does not, where there
  /// are none, or where the file cannot be written.
  void write(TileStore& cloud, const std::filesystem::path& path) const;

 private:
  const GridFrame& grid_;
  double cell_m_;
  std::map<TileIndex, Eigen::AlignedBox3d> places_;  ///< in the grid
};

}  // namespace cf
