// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "cf/densify/stereo_matcher.h"
#include "elas_descriptor.h"

namespace cf {

/// A match found with certainty: pixel (u, v) of the reference has disparity d [px].
struct SupportPoint {
  int u = 0, v = 0, d = 0;
};

/// Matches on a grid of the reference (Geiger et al. 2010, section 3.1): the best of the whole
/// range, much better than the second best, the same from the partner's side, textured, and alike
/// some of those around. In order of v, then u.
std::vector<SupportPoint> supportPoints(const StereoInput& input, const SobelImages& reference,
                                        const SobelImages& partner);

}  // namespace cf
