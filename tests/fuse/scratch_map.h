// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <memory>
#include <utility>

#include "cf/fuse/voxel_tile_map.h"
#include "support/temp_folder.h"

namespace cf::test {

/// A map with a scratch folder of its own.
class ScratchMap : public TileMap {
 public:
  explicit ScratchMap(const FuseOptions& options)
      : ScratchMap(options, std::make_shared<support::TempFolder>()) {}

  std::map<TileIndex, Tile> tiles() const {
    std::map<TileIndex, Tile> result;
    for (const TileIndex index : indices()) result[index] = tile(index);
    return result;
  }

 private:
  using Folder = std::shared_ptr<support::TempFolder>;
  ScratchMap(const FuseOptions& options, Folder folder)
      : TileMap(options, *folder / "scratch"), folder_(std::move(folder)) {}

  Folder folder_;
};

}  // namespace cf::test
