// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "elas_support.h"

namespace cf {

/// What the support points say of the disparities of one image, before its pixels are looked at.
struct ElasPrior {
  static constexpr int kCell = 10;  ///< px

  /// `points` in the coordinates of the image, which is `size` large.
  ElasPrior(const std::vector<SupportPoint>& points, cv::Size size);
  /// Disparities [px] of the support points in and beside the cell of a pixel, ascending.
  struct Near {
    const int *first, *last;
    const int* begin() const { return first; }
    const int* end() const { return last; }
  };
  Near near(int u, int v) const {
    const std::size_t cell =
        static_cast<std::size_t>(v / kCell) * columns + static_cast<std::size_t>(u / kCell);
    return {values.data() + starts[cell], values.data() + starts[cell + 1]};
  }

  cv::Mat plane;  ///< CV_16S, 1/16 px: linear within each triangle of the points; or kNoDisparity
  std::size_t columns;
  std::vector<std::size_t> starts;  ///< in `values`, of each cell and the end
  std::vector<int> values;
};

}  // namespace cf
