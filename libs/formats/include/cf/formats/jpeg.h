// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <string>

namespace cf {

bool isJpeg(const std::uint8_t* bytes, std::size_t size);

/// CV_8UC3, blue first, at 1 / `reduction` of its size, rounded up (1, 2, 4 or 8: the decoder does
/// not compute more than that). Turned as it is stored, whatever its EXIF says. The same pixels as
/// cv::imdecode gives, which takes a third longer: it sorts the colours after decoding. Empty where
/// the file cannot be decoded; one that breaks off is filled with grey.
cv::Mat decodeJpeg(const std::uint8_t* bytes, std::size_t size, int reduction = 1);

/// Of CV_8UC3, blue first; `quality` to 100. Throws RunError where the image is empty or too large.
std::string encodeJpeg(const cv::Mat& image, int quality);

}  // namespace cf
