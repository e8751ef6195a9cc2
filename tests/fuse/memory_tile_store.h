// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>

#include "cf/formats/tile_store.h"

namespace cf::test {

/// A store that keeps its tiles in memory.
class MemoryTileStore : public TileStore {
 public:
  std::optional<Tile> load(TileIndex index) override {
    const auto found = tiles.find(index);
    if (found == tiles.end()) return std::nullopt;
    return found->second;
  }
  void save(const Tile& tile) override { tiles[tile.index] = tile; }
  std::vector<TileIndex> indices() const override {
    std::vector<TileIndex> result;
    for (const auto& [index, tile] : tiles) result.push_back(index);
    return result;
  }
  void flush() override {}

  std::map<TileIndex, Tile> tiles;
};

}  // namespace cf::test
