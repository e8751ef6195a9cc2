// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "extrema.h"

namespace cf::sift {

/// Main directions of the gradients around a keypoint [rad] (Lowe 2004, section 5): the strongest
/// and every other of at least 0.8 of its weight. `level` is the Gaussian level nearest to the
/// keypoint's.
std::vector<float> orientations(const Plane& level, const Keypoint& keypoint);

/// Histograms of gradient directions, 4 x 4 cells by 8 directions (section 6), as RootSIFT
/// (Arandjelovic & Zisserman 2012) times 512, clamped to 255. The gradients are those of a patch
/// resampled in the keypoint's own scale and orientation.
void describe(const Plane& level, const Keypoint& keypoint, float orientation, std::uint8_t* out);

}  // namespace cf::sift
