// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "lanes.h"
#include "semi_global.h"

namespace cf {

inline constexpr Cost kFar = 0x3FFF;  // path cost of a disparity that was not searched

/// Where the disparities of one row's pixels lie in its part of the cost volume.
struct RowLayout {
  std::vector<int> min, count, start;
  int total = 0;

  RowLayout(const TileRanges& ranges, int tile_row, int width) {
    for (int u = 0; u < width; ++u) {
      const std::size_t tile = ranges.at(u / TileRanges::kTile, tile_row);
      min.push_back(ranges.min_px[tile]);
      count.push_back(ranges.count_px[tile]);
      start.push_back(total);
      total += count.back();
    }
  }
  /// In a path buffer each pixel has one entry of kFar before and after its own.
  std::size_t slot(int u) const {
    const auto k = static_cast<std::size_t>(u);
    return static_cast<std::size_t>(start[k]) + 2 * k + 1;
  }
  std::size_t slots() const { return static_cast<std::size_t>(total) + 2 * min.size(); }
};

/// Best disparity of each reference pixel of a row, sub-pixel, checked against the partner's best.
class RowWinner {
 public:
  RowWinner(int width, int partner_width, int max_count);
  /// From the sums of path costs to disparities as StereoMatcher::match returns them.
  void run(const Cost* sum, const RowLayout& layout, std::int16_t* disparity);

 private:
  int partner_width_;
  std::vector<int> best_;
  std::vector<Cost> partner_least_, partner_match_;
};

}  // namespace cf
