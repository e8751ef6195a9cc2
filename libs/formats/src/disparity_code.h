// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace cf {

/// Disparity and confidence of a depth frame without loss, small and fast: what a plane through the
/// neighbours left, above and above left does not foretell, as one byte a pixel, pressed by zstd's
/// fastest level. Rare larger surprises stand apart as they are.
struct DisparityCode {
  std::string residuals;    ///< zstd: a byte a pixel
  std::string surprises;    ///< two bytes each, little endian
  std::string confidences;  ///< zstd: difference to the last matched pixel, a byte a pixel
};

/// CV_16UC1 (0 = no match) and CV_8UC1 of one size.
DisparityCode encodeDisparity(const cv::Mat& disparity, const cv::Mat& confidence);

/// False: these are not the code of images of `size`.
bool decodeDisparity(std::string_view residuals, std::string_view surprises,
                     std::string_view confidences, cv::Size size, cv::Mat& disparity,
                     cv::Mat& confidence);

}  // namespace cf
