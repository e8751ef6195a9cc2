// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstdlib>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "lanes.h"

namespace cf {

/// Responses of the 3 x 3 Sobel masks of a grey image, halved twice and shifted to 0..255, with a
/// border of kBorder.
struct SobelImages {
  static constexpr int kBorder = 8;  ///< px, on each side

  explicit SobelImages(const cv::Mat& grey);
  /// Responses at (0, v).
  const std::uint8_t* acrossRow(int v) const { return across.ptr(v + kBorder) + kBorder; }
  const std::uint8_t* downRow(int v) const { return down.ptr(v + kBorder) + kBorder; }

  cv::Size size;         ///< of the image
  cv::Mat across, down;  ///< CV_8U, size plus borders
};

/// Descriptors of one row of pixels, one after the other; they are compared by the sum of absolute
/// differences.
struct DescriptorRow {
  std::vector<std::uint8_t> values;

  /// For dense matching: all responses along the row in 5 x 5 px and the centre's 7 down the
  /// column.
  static constexpr int kDense = 32;
  void makeDense(const SobelImages& sobel, int v);

  /// For support points: every other row of 9 x 9 px, five along the row and two down the column.
  static constexpr int kSupport = 64;
  void makeSupport(const SobelImages& sobel, int v);
};

template <int kSize>
CF_INLINE int difference(const std::uint8_t* a, const std::uint8_t* b) {
  int sum = 0;
#pragma GCC unroll 1  // unrolled, it is no longer seen as the one instruction that it is
  for (int k = 0; k < kSize; ++k) sum += std::abs(a[k] - b[k]);
  return sum;
}

}  // namespace cf
