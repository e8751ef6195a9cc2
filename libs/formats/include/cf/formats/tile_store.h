// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <vector>

#include "cf/types/tile.h"

namespace cf {

/// Where tiles are kept while they are not in memory. All methods throw RunError where the medium
/// fails.
class TileStore {
 public:
  virtual ~TileStore() = default;
  /// None where the tile was never saved.
  virtual std::optional<Tile> load(TileIndex index) = 0;
  /// Replaces an earlier version as a whole.
  virtual void save(const Tile& tile) = 0;
  /// Ascending.
  virtual std::vector<TileIndex> indices() const = 0;
  /// What was saved is on the medium and listed when it returns.
  virtual void flush() = 0;
};

/// DIR/tiles/<ix>_<iy>.pcd and DIR/tiles.json:
///   {"tile_size_m", "voxel_size_m", "fields", "tiles": [{"x", "y", "file", "offset_m", "points"}]}
/// Each tile is saved atomically; the list is rewritten, atomically, by flush(). A tile saved after
/// the last flush is found again by open(): the files count, not the list.
class DirectoryTileStore : public TileStore {
 public:
  /// An empty store; tiles that an earlier run left in the folder are removed.
  static DirectoryTileStore create(const std::filesystem::path& directory, double tile_size_m,
                                   double voxel_size_m);
  /// The store that create() once made there, with all its tiles.
  static DirectoryTileStore open(const std::filesystem::path& directory);

  std::optional<Tile> load(TileIndex index) override;
  void save(const Tile& tile) override;
  std::vector<TileIndex> indices() const override;
  void flush() override;

  double tileSize() const { return tile_size_m_; }
  double voxelSize() const { return voxel_size_m_; }

 private:
  struct Entry {
    Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();
    std::size_t points = 0;
  };
  DirectoryTileStore(std::filesystem::path directory, double tile_size_m, double voxel_size_m);
  std::filesystem::path file(TileIndex index) const;

  std::filesystem::path directory_;
  double tile_size_m_ = 0;
  double voxel_size_m_ = 0;
  std::map<TileIndex, Entry> entries_;
};

}  // namespace cf
