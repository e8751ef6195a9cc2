// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <opencv2/core/mat.hpp>

#include "cf/types/ids.h"

namespace cf {

/// The photos themselves, 8-bit grey, of any size, for what features alone cannot tell; empty where
/// there is none. Called from several threads.
using PhotoSource = std::function<cv::Mat(FrameId)>;

}  // namespace cf
