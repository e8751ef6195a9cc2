// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "cf/types/map_point.h"
#include "cf/types/tile.h"
#include "voxel_index.h"

namespace cf {

/// The voxels of one tile: weighted sums of position and colour, and the number of views. A voxel
/// is kHeightOverSide times as high as wide: seen from above, height is that much less certain than
/// the horizontal position (by depth over baseline), and cubes would hold the noise of each pair
/// instead of the mean of all.
/// Sums are relative to the voxel's centre, so that floats hold them to a millionth of a voxel.
class VoxelTile {
 public:
  static constexpr double kHeightOverSide = 3;

  VoxelTile(TileIndex index, double tile_m, double voxel_m);

  /// Merges the points [begin, end). `view` differs from one depth frame to the next; 0 is none.
  /// Returns how many were merged: points too high or deep for the grid (a million voxels) are not.
  std::size_t add(const MapPoint* begin, const MapPoint* end, std::uint32_t view);
  /// Merges what toTile() once gave: sums are restored from means, weights and views.
  void merge(const Tile& tile);
  /// One point a voxel, each inside its voxel even after rounding to float, in the order (z, y, x).
  Tile toTile() const;

  std::size_t size() const { return voxels_.size(); }
  std::size_t bytes() const;

 private:
  struct Voxel {
    float weight = 0;
    float offset[3] = {0, 0, 0};  ///< weighted sum [voxel sides from the centre]
    float bgr[3] = {0, 0, 0};     ///< weighted sum
    std::uint32_t last_view = 0;
    std::uint16_t views = 0;
  };

  /// Where a position falls: the voxel, and the place in it [voxel sides from its centre].
  struct Place {
    std::uint64_t key;
    float rest[3];
  };

  /// False where the position is outside the grid.
  bool locate(const Eigen::Vector3d& relative_m, Place& place) const;
  Voxel& voxelAt(const Place& place);
  std::int64_t cellOf(double relative_m, int axis) const;
  float positionInCell(double relative_m, std::int64_t cell, int axis) const;

  TileIndex index_;
  Eigen::Vector3d offset_m_;
  Eigen::Vector3d voxel_m_;
  Eigen::Vector3d inverse_voxel_;
  VoxelIndex numbers_;
  std::vector<Voxel> voxels_;
};

}  // namespace cf
