// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "voxel_index.h"

namespace cf {

/// A set of grid cells in bricks of 4 x 4 x 4, one bit a cell: a tenth of the memory of a hash set.
class BrickSet {
 public:
  /// False where the cell was in it already. Cells must fit CellKey.
  bool insert(std::int64_t x, std::int64_t y, std::int64_t z) {
    const std::uint32_t brick = bricks_.findOrAdd(brickKey(x, y, z));
    if (brick == bits_.size()) bits_.push_back(0);
    const std::uint64_t bit = bitOf(x, y, z);
    const bool added = (bits_[brick] & bit) == 0;
    bits_[brick] |= bit;
    size_ += added;
    return added;
  }

  bool contains(std::int64_t x, std::int64_t y, std::int64_t z) const {
    const std::uint32_t brick = bricks_.find(brickKey(x, y, z));
    return brick != VoxelIndex::kNone && (bits_[brick] & bitOf(x, y, z)) != 0;
  }

  /// Calls visit(x, y, z) for each cell, by brick in order of arrival.
  template <class Visitor>
  void forEach(const Visitor& visit) const {
    for (std::uint32_t brick = 0; brick < bits_.size(); ++brick) {
      const std::uint64_t key = bricks_.keys()[brick];
      for (int bit = 0; bit < 64; ++bit)
        if (bits_[brick] >> bit & 1)
          visit(4 * CellKey::x(key) + (bit & 3), 4 * CellKey::y(key) + (bit >> 2 & 3),
                4 * CellKey::z(key) + (bit >> 4));
    }
  }

  std::size_t size() const { return size_; }

 private:
  // Shifts of negative numbers round down (g++ and clang; C++20).
  static std::uint64_t brickKey(std::int64_t x, std::int64_t y, std::int64_t z) {
    return CellKey::pack(x >> 2, y >> 2, z >> 2);
  }
  static std::uint64_t bitOf(std::int64_t x, std::int64_t y, std::int64_t z) {
    return std::uint64_t{1} << ((x & 3) | (y & 3) << 2 | (z & 3) << 4);
  }

  VoxelIndex bricks_;
  std::vector<std::uint64_t> bits_;
  std::size_t size_ = 0;
};

}  // namespace cf
