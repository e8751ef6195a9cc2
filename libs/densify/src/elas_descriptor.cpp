// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "elas_descriptor.h"

#include <cstring>
#include <opencv2/imgproc.hpp>

namespace cf {
namespace {

/// Copies `count` bytes at once to each descriptor; what follows them is overwritten later.
template <int kSize, int kCopied>
CF_INLINE void gather(const std::uint8_t* from, int width, std::uint8_t* to) {
  for (int u = 0; u < width; ++u) std::memcpy(to + kSize * u, from + u, kCopied);
}

}  // namespace

SobelImages::SobelImages(const cv::Mat& grey) : size(grey.size()) {
  cv::Mat padded;
  cv::copyMakeBorder(grey, padded, kBorder, kBorder, kBorder, kBorder, cv::BORDER_REPLICATE);
  cv::Sobel(padded, across, CV_16S, 1, 0);
  cv::Sobel(padded, down, CV_16S, 0, 1);
  across.convertTo(across, CV_8U, 0.25, 128);
  down.convertTo(down, CV_8U, 0.25, 128);
}

void DescriptorRow::makeDense(const SobelImages& sobel, int v) {
  const int width = sobel.size.width;
  values.resize(static_cast<std::size_t>(width) * kDense + 8);
  for (int row = 0; row < 5; ++row) {
    gather<kDense, 8>(sobel.acrossRow(v + row - 2) - 2, width, values.data() + 5 * row);
  }
  gather<kDense, 7>(sobel.downRow(v) - 3, width, values.data() + 25);
}

void DescriptorRow::makeSupport(const SobelImages& sobel, int v) {
  const int width = sobel.size.width;
  values.resize(static_cast<std::size_t>(width) * kSupport + 16);
  for (int row = 0; row < 5; ++row) {
    gather<kSupport, 16>(sobel.acrossRow(v + 2 * row - 4) - 4, width, values.data() + 9 * row);
  }
  gather<kSupport, 16>(sobel.downRow(v - 2) - 4, width, values.data() + 45);
  gather<kSupport, 10>(sobel.downRow(v + 2) - 4, width, values.data() + 54);
}

}  // namespace cf
