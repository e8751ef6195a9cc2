// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "scale_space.h"

namespace cf::sift {

/// A blob. Octave o's pixel x lies at x * 2^o of the image.
struct Keypoint {
  int octave = 0;
  float x = 0, y = 0;  ///< [px of the octave]
  float level = 0;
  float response = 0;  ///< |D| there
};

/// Extrema of the differences of Gaussians over space and scale, located by a quadratic fit,
/// without those of little contrast (|D| * kScales below `contrast`, for an image from 0 to 1) and
/// those on edges (Lowe 2004, sections 3 and 4). They come by row, level and column.
void findExtrema(const Octave& octave, int octave_index, double contrast,
                 std::vector<Keypoint>& keypoints);

}  // namespace cf::sift
