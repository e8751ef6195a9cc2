// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>

#include "cf/formats/tile_store.h"
#include "cf/fuse/fuse_options.h"
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
/// given. The store holds the raw tiles (TileMap::flush before) and is not changed; no more than
/// options.max_memory_mb of them are in memory, and at least four tiles with their
/// neighbours, which are cleaned side by side.
/// options.voxel_m and tile_m are those of the TileMap.
Delivery deliverCloud(TileStore& store, const FuseOptions& options,
                      const std::function<void(const Tile&)>& sink);

}  // namespace cf
