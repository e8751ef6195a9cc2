// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

#include "cf/geometry/rectification.h"

namespace cf {

/// cv::remap, bilinear and with its border replicated, to the last bit, of CV_8UC1 or CV_8UC3:
/// into `out`, of the table's size and the image's type.
void resample(const cv::Mat& image, const RemapTable& table, cv::Mat out);

}  // namespace cf
