// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <vector>

#include "cf/fuse/fuse_options.h"
#include "cf/types/ids.h"
#include "cf/types/map_point.h"
#include "cf/types/tile.h"

namespace cf {

class VoxelTile;

/// The fused map: voxels of `voxel_m`, three times as high as wide, in square tiles of `tile_m`,
/// each with the weighted means of position and colour, the sum of the weights, and the number of
/// depth frames that saw it (to 4095). Means do not depend on the order of insertion beyond
/// rounding, a thousandth of a voxel's side.
///
/// Tiles in memory are held below `max_memory_mb`: the longest unused go to files of a scratch
/// folder and come back, bit by bit what they were, when the map returns to them. Those that a
/// frame falls on are filled side by side. The result depends neither on the threads nor on the
/// memory. Not thread-safe but where noted.
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

  /// `scratch` is made where it is needed, and removed with all that is in it at the end. Throws
  /// UsageError where options.voxel_m is still 0, exceeds the tile, or is too small for it.
  TileMap(const FuseOptions& options, std::filesystem::path scratch);
  ~TileMap();
  TileMap(const TileMap&) = delete;
  TileMap& operator=(const TileMap&) = delete;

  /// Merges the points of one depth frame. Inserts under the same id one after the other count as
  /// one view of a voxel. Throws RunError where the scratch folder fails.
  void insert(FrameId depth_frame, const MapPoints& points);

  /// Of all tiles that have been filled, ascending.
  std::vector<TileIndex> indices() const;
  /// A tile as it is now, one point a voxel. It stays where it is.
  Tile tile(TileIndex index) const;
  /// Writes all tiles that changed, after which none is in memory.
  void leaveMemory();

  Stats stats() const;

 private:
  struct Entry;
  struct Run;
  using Runs = std::map<TileIndex, std::vector<Run>>;

  Runs runsByTile(const MapPoints& points);
  void fill(const std::vector<TileIndex>& tiles, const Runs& runs, const MapPoints& points);
  std::filesystem::path file(TileIndex index) const;
  void makeRoom(std::size_t wanted_bytes);
  void evict(TileIndex index, Entry& entry);
  std::size_t bytes() const;

  const FuseOptions options_;
  const std::filesystem::path scratch_;
  std::map<TileIndex, Entry> tiles_;
  FrameId view_frame_;
  std::uint32_t view_ = 0;   ///< number of the depth frame in work
  std::uint64_t clock_ = 0;  ///< counts uses of tiles
  Stats stats_;
};

}  // namespace cf
