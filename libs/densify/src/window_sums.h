// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "lanes.h"

namespace cf {

/// Sums of several quantities over a square window, row by row: begin(), fill the rows of the
/// quantities, push(); after push() of row v, sums are those of windows about row v - kRadius.
/// Beyond the image everything counts as zero.
class WindowSums {
 public:
  static constexpr int kRadius = 3;  ///< px
  static constexpr int kSide = 2 * kRadius + 1;

  WindowSums(int quantities, int width)
      : quantities_(quantities),
        stride_(static_cast<std::size_t>(width) + 2 * kRadius),
        rows_(static_cast<std::size_t>(quantities * kRows) * stride_),
        columns_(static_cast<std::size_t>(quantities) * stride_),
        width_(width) {}

  /// The row to fill with a quantity.
  std::int32_t* begin(int quantity) { return rowOf(quantity, at_) + kRadius; }
  /// Instead of filling it.
  void fillZero(int quantity) { std::fill_n(begin(quantity), width_, 0); }
  void push() {
    const int leaving = (at_ + 1) % kRows;
    for (int q = 0; q < quantities_; ++q)
      exchange(rowOf(q, at_), rowOf(q, leaving), columnsOf(q), static_cast<int>(stride_));
    at_ = leaving;
  }
  void sums(int quantity, std::int32_t* out) const {
    sum(columns_.data() + static_cast<std::size_t>(quantity) * stride_, width_, out);
  }

 private:
  static constexpr int kRows = kSide + 1;  ///< of the window, and the one that leaves it

  std::int32_t* rowOf(int quantity, int row) {
    return rows_.data() + static_cast<std::size_t>(quantity * kRows + row) * stride_;
  }
  std::int32_t* columnsOf(int quantity) {
    return columns_.data() + static_cast<std::size_t>(quantity) * stride_;
  }
  static void exchange(const std::int32_t* coming, const std::int32_t* leaving,
                       std::int32_t* columns, int n);
  static void sum(const std::int32_t* columns, int width, std::int32_t* out);

  int quantities_;
  std::size_t stride_;
  std::vector<std::int32_t> rows_, columns_;
  int width_, at_ = 0;
};

}  // namespace cf
