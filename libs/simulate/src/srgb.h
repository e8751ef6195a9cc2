// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

namespace cf {

/// sRGB's tone curve (IEC 61966-2-1): linear light to a photo's level, both 0 to 1.
inline double srgbOf(double light) {
  return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}

}  // namespace cf
