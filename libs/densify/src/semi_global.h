// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace cf {

/// The disparities searched in each tile of the reference: [min, min + count); none where count is
/// 0.
struct TileRanges {
  static constexpr int kTile = 8;        ///< px
  static constexpr int kCountStep = 16;  ///< counts are multiples of it

  TileRanges(cv::Size image, int min, int count)
      : columns((image.width + kTile - 1) / kTile),
        rows((image.height + kTile - 1) / kTile),
        min_px(static_cast<std::size_t>(columns * rows), min),
        count_px(min_px.size(), roundedUp(count)) {}
  static int roundedUp(int count) { return (count + kCountStep - 1) / kCountStep * kCountStep; }
  std::size_t at(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(column);
  }

  int columns, rows;
  std::vector<int> min_px, count_px;
};

struct SemiGlobalPenalties {
  int small = 6;        ///< P1: of a step of 1 px, in bits of the census cost (0..12)
  int large = 36;       ///< P2: of a larger step where the grey does not change
  int large_floor = 7;  ///< P2 across a strong edge of the grey
};

/// Semi-global matching (Hirschmueller 2008) along four paths (rows and columns, both ways; the
/// diagonals double the time and add no accuracy on real pairs) with a centre-symmetric census cost
/// over 5 x 5 px. Sub-pixel by the parabola through the minimum; left-right check against the
/// partner's own minimum in the same cost volume. CV_16SC1 as StereoMatcher::match returns it.
cv::Mat semiGlobalMatch(const cv::Mat& reference, const cv::Mat& partner, const TileRanges& ranges,
                        const SemiGlobalPenalties& penalties = {});

}  // namespace cf
