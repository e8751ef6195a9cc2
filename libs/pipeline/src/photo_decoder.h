// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>
#include <string>

#include "cf/base/result.h"
#include "cf/types/image_frame.h"

namespace cf {

/// Decodes a photo at the smallest of JPEG's scales 1, 1/2, 1/4 that keeps `megapixels`. Failure:
/// "damaged" with the reason; a JPEG that breaks off counts as damaged.
Result<cv::Mat> decodePhoto(const ImageFrame& photo, double megapixels);

/// A photo taken up: what all stages see of it.
struct TakenPhoto {
  cv::Mat image;     ///< BGR
  std::string jpeg;  ///< the same size: the file itself, or, where it was reduced, of quality 95
};

/// The one time that a photo is decoded from its file: at a scale as decodePhoto() chooses it.
Result<TakenPhoto> takePhoto(const ImageFrame& photo, double megapixels);

}  // namespace cf
