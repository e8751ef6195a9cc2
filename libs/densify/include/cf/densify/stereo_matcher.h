// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>

#include "cf/densify/densify.h"

namespace cf {

/// Two rectified grey images: pixel (u, v) of the reference shows what (u - d, v) of the partner
/// shows, d within [min_disparity_px, max_disparity_px]. Outside the photo the grey is meaningless
/// and `inside` is 0.
struct StereoInput {
  cv::Mat reference, partner;                ///< CV_8UC1, equal heights
  cv::Mat reference_inside, partner_inside;  ///< CV_8UC1, 255 or 0
  int min_disparity_px = 0, max_disparity_px = 0;
};

/// Disparity of a pixel that has none.
inline constexpr std::int16_t kNoDisparity = INT16_MIN;
/// Disparities must stay below it, either sign, to fit 16 bits [px].
inline constexpr int kMostDisparity_px = 2000;

struct StereoOutput {
  cv::Mat disparity;   ///< CV_16SC1, 1/16 px, or kNoDisparity
  cv::Mat confidence;  ///< CV_8UC1, 0..255; 0 where there is no disparity
};

/// Dense matching of a rectified pair. Implementations own no state between calls.
class StereoMatcher {
 public:
  virtual ~StereoMatcher() = default;
  /// Disparity of each reference pixel that has one, after the left-right, border and speckle
  /// checks, and how far to trust it.
  virtual StereoOutput match(const StereoInput& input) const = 0;
};

/// The matcher named options.matcher, "sgm" or "elas" (options.visit() accepts no other).
std::unique_ptr<StereoMatcher> makeStereoMatcher(const DensifyOptions& options);

}  // namespace cf
