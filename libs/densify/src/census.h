// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

namespace cf {

/// Centre-symmetric census of a grey image over 9 x 7 px (CV_32S): one bit for each of the 31 pairs
/// of pixels opposite each other about the centre.
cv::Mat census(const cv::Mat& image);

}  // namespace cf
