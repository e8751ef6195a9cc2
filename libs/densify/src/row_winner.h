// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "row_layout.h"

namespace cf {

/// Best disparity of each reference pixel of a row, sub-pixel, checked against the partner's best.
class RowWinner {
 public:
  explicit RowWinner(int partner_width) : partner_width_(partner_width) {}
  /// From the sums of path costs to disparities as StereoMatcher::match returns them.
  void run(const PathCost* sum, const RowLayout& layout, int width, std::int16_t* disparity);

 private:
  int partner_width_;
  std::vector<PathCost> partner_least_;
};

}  // namespace cf
