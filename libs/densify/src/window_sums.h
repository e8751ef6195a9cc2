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
        rows_(static_cast<std::size_t>(quantities * kSide) * stride_),
        columns_(static_cast<std::size_t>(quantities) * stride_),
        width_(width) {}

  /// The row to fill with a quantity; what it held leaves the sums.
  std::int32_t* begin(int quantity) {
    std::int32_t* row = rowOf(quantity);
    subtract(row - kRadius, columnsOf(quantity), static_cast<int>(stride_));
    return row;
  }
  /// Instead of filling it.
  void fillZero(int quantity) { std::fill_n(begin(quantity), width_, 0); }
  void push() {
    for (int q = 0; q < quantities_; ++q) {
      add(rowOf(q) - kRadius, columnsOf(q), static_cast<int>(stride_));
    }
    at_ = (at_ + 1) % kSide;
  }
  void sums(int quantity, std::int32_t* out) const {
    sum(columns_.data() + static_cast<std::size_t>(quantity) * stride_, width_, out);
  }

 private:
  std::int32_t* rowOf(int quantity) {
    return rows_.data() + static_cast<std::size_t>(quantity * kSide + at_) * stride_ + kRadius;
  }
  std::int32_t* columnsOf(int quantity) {
    return columns_.data() + static_cast<std::size_t>(quantity) * stride_;
  }
  static void subtract(const std::int32_t* row, std::int32_t* columns, int n);
  static void add(const std::int32_t* row, std::int32_t* columns, int n);
  static void sum(const std::int32_t* columns, int width, std::int32_t* out);

  int quantities_;
  std::size_t stride_;
  std::vector<std::int32_t> rows_, columns_;
  int width_, at_ = 0;
};

}  // namespace cf
