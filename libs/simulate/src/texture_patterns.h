// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include "texture_noise.h"

namespace cf {

/// Share of [x - footprint/2, x + footprint/2] that lies in [low, high].
inline float inside(float x, float low, float high, float footprint) {
  const float a = std::fmax(low, x - footprint / 2), b = std::fmin(high, x + footprint / 2);
  return b > a ? (b - a) / footprint : 0.0F;
}

/// Share of [x - footprint/2, x + footprint/2] covered by the bars [k period, k period + width].
inline float bars(float x, float period, float width, float footprint) {
  auto covered = [&](float v) {
    const float k = std::floor(v / period);
    return k * width + std::fmin(v - k * period, width);
  };
  return (covered(x + footprint / 2) - covered(x - footprint / 2)) / footprint;
}

/// A random number in [-1, 1] for each cell of a lattice, fading where cells are not resolved.
inline float cellNoise(float x, float y, float width, float height, float footprint,
                       std::uint32_t seed) {
  const float seen = visible(std::fmin(width, height), footprint);
  if (seen <= 0) return 0;
  const auto column = static_cast<std::uint32_t>(floorInt(x / width));
  const auto row = static_cast<std::uint32_t>(floorInt(y / height));
  return seen * (2 * unit(hash2(seed ^ column, row)) - 1);
}

}  // namespace cf
