// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "row_layout.h"
#include "semi_global.h"

namespace cf {

/// Two of the four paths: along the rows and down the columns, or both the other way.
class PathSweep {
 public:
  /// `direction` +1: left to right and top to bottom, -1: the other way.
  PathSweep(const cv::Mat& grey, const SemiGlobalPenalties& penalties, int direction, int max_count,
            std::size_t max_slots);

  /// Adds the two path costs of row v to `sum`; the forward sweep sets it. `last_layout` is that of
  /// the row before, null in the sweep's first row.
  void row(int v, const RowLayout& layout, const RowLayout* last_layout, const std::uint8_t* cost,
           PathCost* sum);

 private:
  void setLarge(int v, bool has_last);
  void moveDown(const RowLayout& layout, const RowLayout* last_layout);

  const cv::Mat& grey_;
  const SemiGlobalPenalties& penalties_;
  const int direction_;
  std::vector<PathCost> down_, last_down_;  ///< path costs down the columns, in slots
  std::vector<PathCost> along_, along_scratch_;
  std::vector<PathCost> large_along_, large_down_;  ///< P2 of the steps into each pixel
};

}  // namespace cf
