// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "lanes.h"
#include "semi_global.h"

namespace cf {

/// Matching costs (0 to 12) and path costs less their minimum (up to P2 more) fit a byte, and so do
/// the sums of four paths.
using PathCost = std::uint8_t;

inline constexpr PathCost kFar = 0x7F;  ///< path cost of a disparity that was not searched

/// Pixels [first, end) of a row that search the same disparities [min, min + count).
struct PixelRun {
  int first, end, min, count;
  /// Where the costs of the run's first pixel lie in the row's part of the cost volume, and in a
  /// path buffer, where each pixel has one entry of kFar before and after its own.
  std::size_t cells, slots;

  std::size_t cell(int u) const {
    return cells + static_cast<std::size_t>(u - first) * static_cast<std::size_t>(count);
  }
  std::size_t slot(int u) const {
    return slots + static_cast<std::size_t>(u - first) * static_cast<std::size_t>(count + 2) + 1;
  }
};

/// Where the disparities of one row's pixels lie: runs from left to right, none of pixels that
/// search nothing.
struct RowLayout {
  std::vector<PixelRun> runs;
  std::size_t cells = 0, slots = 0;  ///< of the whole row
  int max_count = 0;

  RowLayout(const TileRanges& ranges, int tile_row, int width) {
    for (int column = 0; column < ranges.columns; ++column) {
      const std::size_t tile = ranges.at(column, tile_row);
      const int min = ranges.min_px[tile], count = ranges.count_px[tile];
      const int first = column * TileRanges::kTile;
      const int end = std::min(width, first + TileRanges::kTile);
      if (count == 0) continue;
      if (!runs.empty() && runs.back().end == first && runs.back().min == min &&
          runs.back().count == count) {
        runs.back().end = end;
      } else {
        runs.push_back({first, end, min, count, cells, slots});
      }
      const auto pixels = static_cast<std::size_t>(end - first);
      cells += pixels * static_cast<std::size_t>(count);
      slots += pixels * static_cast<std::size_t>(count + 2);
      max_count = std::max(max_count, count);
    }
  }
};

}  // namespace cf
