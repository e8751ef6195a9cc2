// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "census.h"

#include <algorithm>
#include <cstdint>
#include <opencv2/imgproc.hpp>

#include "lanes.h"

namespace cf {
namespace {

constexpr int kCensusX = 2, kCensusY = 2;

CF_CLONES void censusRow(const uchar* const* rows, int width, std::uint16_t* census) {
  std::fill_n(census, width, std::uint16_t{0});
  for (int dy = 0; dy <= kCensusY; ++dy) {
    for (int dx = -kCensusX; dx <= kCensusX; ++dx) {
      if (dy == 0 && dx <= 0) continue;
      const uchar* below = rows[kCensusY + dy] + dx;
      const uchar* above = rows[kCensusY - dy] - dx;
      for (int u = 0; u < width; ++u) {
        census[u] =
            static_cast<std::uint16_t>((census[u] << 1) | static_cast<int>(below[u] > above[u]));
      }
    }
  }
}

}  // namespace

cv::Mat census(const cv::Mat& image) {
  cv::Mat padded;
  cv::copyMakeBorder(image, padded, kCensusY, kCensusY, kCensusX, kCensusX, cv::BORDER_REPLICATE);
  cv::Mat out(image.size(), CV_16U);
  for (int v = 0; v < image.rows; ++v) {
    const uchar* rows[2 * kCensusY + 1];
    for (int k = 0; k < 2 * kCensusY + 1; ++k) rows[k] = padded.ptr<uchar>(v + k) + kCensusX;
    censusRow(rows, image.cols, out.ptr<std::uint16_t>(v));
  }
  return out;
}

}  // namespace cf
