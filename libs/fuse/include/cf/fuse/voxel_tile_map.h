// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "cf/formats/tile_store.h"
#include "cf/fuse/fuse_options.h"
#include "cf/types/ids.h"
#include "cf/types/map_point.h"

namespace cf {

class VoxelTile;

/// The fused map: voxels of `voxel_m`, three times as high as wide, in square tiles of `tile_m`,
/// each with the weighted means of position and colour, the sum of the weights, and the number of
/// depth frames that saw it. Means do not depend on the order of insertion beyond float rounding.
///
/// Tiles in memory are held below `max_memory_mb`: the longest unused go to the store and come
/// back, with nothing lost but rounding (colours to 1/255, positions to a float), when the map
/// returns to them. At least the tile in work stays. Not thread-safe.
class TileMap {
 public:
  struct Stats {
    std::size_t points = 0;   ///< merged
    std::size_t dropped = 0;  ///< not finite, weight not positive, or absurdly far (> 10^8 tiles)
    std::size_t saved = 0;    ///< tiles written
    std::size_t reloaded = 0;
    std::size_t resident_tiles = 0;
    std::size_t resident_voxels = 0;
    std::size_t resident_bytes = 0;
  };

  /// The store must outlive the map; what it holds already is merged with. Throws UsageError where
  /// options.voxel_m is still 0 or exceeds the tile.
  TileMap(const FuseOptions& options, TileStore& store);
  ~TileMap();
  TileMap(const TileMap&) = delete;
  TileMap& operator=(const TileMap&) = delete;

  /// Merges the points of one depth frame, in world coordinates. Inserts under the same id one
  /// after the other count as one view of a voxel.
  void insert(FrameId depth_frame, const std::vector<MapPoint>& points);
  /// Writes every tile that changed and flushes the store. Tiles stay in memory.
  void flush();

  Stats stats() const;

 private:
  struct Resident;
  struct Run;

  Resident& resident(TileIndex index);
  void save(Resident& tile);
  void shrink(TileIndex keep);
  std::size_t bytes() const;

  const FuseOptions options_;
  TileStore& store_;
  std::map<TileIndex, Resident> tiles_;
  FrameId view_frame_;
  std::uint32_t view_ = 0;   ///< number of the depth frame in work
  std::uint64_t clock_ = 0;  ///< counts uses of tiles
  Stats stats_;
};

}  // namespace cf
