// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

#include "ortho_ground.h"
#include "ortho_shares.h"
#include "photo_crops.h"

namespace cf {

/// The picture of a window without its margin: CV_8UC4, BGR and 255 where there is a picture.
/// `number`: the window's, for the crops.
cv::Mat paintOrthoWindow(const OrthoScene& scene, PhotoCrops& crops, std::size_t number,
                         const OrthoWindow& window);

}  // namespace cf
