// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "cf/types/map_point.h"
#include "cf/types/tile.h"

namespace cf {

/// The voxels of one tile: weighted means of position and colour, the sum of the weights, and the
/// number of views. A voxel is kHeightOverSide times as high as wide: seen from above, height is
/// that much less certain than the horizontal position (by depth over baseline), and cubes would
/// hold the noise of each pair instead of the mean of all.
///
/// Each vertical column has a voxel in its place, the heaviest so far, and a chain of the others: a
/// surface fills a column with one or two. Neighbouring pixels of a photo fall into neighbouring
/// columns, so that voxels come from the cache, where a hash table would go to memory for each.
///
/// A voxel takes 24 bytes. Means are kept in 16 bits each: to 1/65536 of the voxel's side and 1/257
/// of a colour's step. Rounding after each point stays below a thousandth of the side.
class VoxelTile {
 public:
  static constexpr double kHeightOverSide = 3;
  static constexpr int kMaxColumns = 1024;  ///< along one side

  /// tile_m / voxel_m must not exceed kMaxColumns.
  VoxelTile(TileIndex index, double tile_m, double voxel_m);

  /// Merges the points [begin, end), relative to `origin_m`, all of which lie in this tile. `view`
  /// differs from one depth frame to the next. Returns how many were merged: not finite ones,
  /// those without positive weight and those too high or deep (half a million voxels) are not.
  std::size_t add(const Eigen::Vector3d& origin_m, const MapPoint* begin, const MapPoint* end,
                  std::uint32_t view);
  /// One point a voxel: by squares of columns, in them by y, x and z.
  Tile toTile() const;

  /// Everything, bit by bit, in a file that only the same run reads again. Both throw RunError.
  void save(const std::filesystem::path& path) const;
  /// Into a tile just made, for the same index and sizes.
  void load(const std::filesystem::path& path);

  std::size_t size() const { return size_; }
  std::size_t bytes() const;

 private:
  static constexpr std::uint32_t kBlockSide = 8;
  static constexpr std::uint32_t kSlabVoxels = 512;
  static constexpr std::uint32_t kChunkVoxels = 16;  ///< of the chains of a block, side by side
  static constexpr std::uint32_t kNone = (1u << 24) - 1;
  static constexpr std::uint32_t kMaxViews = (1u << 12) - 1;
  static constexpr std::uint32_t kMaxStamp = (1u << 8) - 1;
  static constexpr std::int32_t kMaxHeight = (1 << 19) - 1;

  struct Arrival;
  struct Grid;
  struct Voxel {
    float weight = 0;         ///< zero where there is nothing yet
    std::uint32_t next : 24;  ///< in the same column
    std::uint32_t stamp : 8;  ///< of the view that saw it last
    std::uint32_t views : 12;
    std::int32_t height : 20;                    ///< cell along z
    std::uint16_t mean[6] = {0, 0, 0, 0, 0, 0};  ///< blue, green, red, x, y and z in the voxel
    Voxel() : next(kNone), stamp(0), views(0), height(0) {}
    void add(const Arrival& arrival, std::uint32_t view_stamp);
  };
  static_assert(sizeof(Voxel) == 24, "a voxel takes 24 bytes");

  /// The columns of a square.
  struct Block {
    std::array<Voxel, kBlockSide * kBlockSide> columns;
    std::uint32_t free = 0;  ///< number for a new voxel; 0 (mod kChunkVoxels) where there is none
  };
  using Slab = std::array<Voxel, kSlabVoxels>;

  Grid gridAround(const Eigen::Vector3d& origin_m) const;
  std::size_t merge(const Grid& grid, const MapPoint* begin, const MapPoint* end);
  bool locate(const Grid& grid, const MapPoint& point, Arrival& arrival);
  Voxel* voxelAt(const Arrival& arrival);
  void startView(std::uint32_t view);
  TilePoint pointOf(const Voxel& v, std::uint32_t i, std::uint32_t j) const;
  Voxel& voxel(std::uint32_t number) {
    return (*slabs_[number / kSlabVoxels])[number % kSlabVoxels];
  }
  const Voxel& voxel(std::uint32_t number) const {
    return (*slabs_[number / kSlabVoxels])[number % kSlabVoxels];
  }

  TileIndex index_;
  Eigen::Vector3d offset_m_;
  double voxel_m_;
  int columns_;  ///< along one side
  std::uint32_t blocks_along_;
  std::vector<std::unique_ptr<Block>> blocks_;  ///< null where there is nothing yet
  std::vector<std::unique_ptr<Slab>> slabs_;
  std::uint32_t size_ = 0;
  std::uint32_t room_ = 0;   ///< chained voxels given to blocks
  std::uint32_t view_ = 0;   ///< in work
  std::uint32_t stamp_ = 0;  ///< that stands for it
  std::size_t filled_blocks_ = 0;
};

}  // namespace cf
