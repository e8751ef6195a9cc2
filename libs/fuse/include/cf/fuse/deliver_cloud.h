// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>

#include "cf/fuse/fuse_options.h"
#include "cf/fuse/voxel_tile_map.h"
#include "cf/types/tile.h"

namespace cf {

/// What became of the fused voxels.
struct Delivery {
  std::size_t tiles = 0;
  std::size_t points = 0;     ///< delivered
  std::size_t flying = 0;     ///< removed by cleaned()
  std::size_t uncertain = 0;  ///< below min_views or min_confidence
};

/// Gives the finished cloud to `sink`, tile by tile in ascending order of index: cleaned of flying
/// points, then without voxels below options.min_views and min_confidence. Tiles left empty are not
/// given. The map is not changed; beside the tiles that it holds in memory (none after
/// TileMap::leaveMemory()) no more than options.max_memory_mb are in memory, and at least four
/// with their neighbours, which are cleaned side by side. options.voxel_m is that of the map.
Delivery deliverCloud(const TileMap& map, const FuseOptions& options,
                      const std::function<void(const Tile&)>& sink);

}  // namespace cf
