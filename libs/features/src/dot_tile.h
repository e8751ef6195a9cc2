// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "cf/types/feature_set.h"

namespace cf {

constexpr int kTileRows = 8;      ///< descriptors of a
constexpr int kTileColumns = 32;  ///< descriptors of b

/// Scalar products of all descriptors of two photos, tile by tile. Integers: every kind of CPU
/// gives the same.
class DotTiles {
 public:
  DotTiles(const FeatureSet& a, const FeatureSet& b);

  int tileRows() const { return tile_rows_; }
  int tileColumns() const { return tile_columns_; }

  /// Products of tile (i, j), kTileRows x kTileColumns; 0 beyond the last descriptor.
  void compute(int i, int j, std::int32_t* out) const;

 private:
  int tile_rows_, tile_columns_;
  bool has_byte_products_;
  std::vector<std::int8_t> shifted_a_;  ///< minus 128
  std::vector<std::uint8_t> packed_b_;  ///< by 16 descriptors, then 4 bytes of each in turn
  std::vector<std::int32_t> shift_;     ///< 128 times the sum of each descriptor of b
  std::vector<std::int16_t> wide_a_, wide_b_;
};

}  // namespace cf
