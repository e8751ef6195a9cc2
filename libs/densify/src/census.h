// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

namespace cf {

/// Centre-symmetric census of a grey image over 5 x 5 px (CV_16U): one bit for each of the 12 pairs
/// of pixels opposite each other about the centre. Larger windows are less noisy, and spread roofs
/// and crowns over what is beside them.
cv::Mat census(const cv::Mat& image);

}  // namespace cf
