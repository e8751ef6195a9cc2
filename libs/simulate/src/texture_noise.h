// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

namespace cf {

/// Lattice spacings of the noise octaves: 20.48 m / 2^k, the last one 1 cm. Most of an octave's
/// energy is at wavelengths from twice its spacing up.
constexpr int kOctaves = 12;
constexpr float kWidestSpacing_m = 20.48F;
/// Amplitude of each octave.
using Spectrum = std::array<float, kOctaves>;

/// A hash of two integers, well mixed.
inline std::uint32_t hash2(std::uint32_t a, std::uint32_t b) {
  std::uint32_t h = a * 0x9E3779B1U ^ (b * 0x85EBCA77U + 0x165667B1U);
  h = (h ^ (h >> 15)) * 0x2C1B3C6DU;
  h = (h ^ (h >> 12)) * 0x297A2D39U;
  return h ^ (h >> 15);
}

/// A number in [0, 1) from a hash.
inline float unit(std::uint32_t h) { return static_cast<float>(h >> 8) * 0x1p-24F; }

/// floor() of a float that fits an int; compiles to vector code without SSE4's rounding.
inline int floorInt(float v) {
  const int i = static_cast<int>(v);
  return i - (v < static_cast<float>(i) ? 1 : 0);
}

/// How much of a detail of the given size survives averaging over a footprint: nothing of one as
/// large as the footprint, all of one twice as large.
inline float visible(float size_m, float footprint_m) {
  const float v = size_m / footprint_m - 1;
  const float t = v < 0 ? 0 : (v > 1 ? 1 : v);
  return t * t * (3 - 2 * t);
}

/// Adds band-limited value noise (mean 0) at n places: octaves with waves shorter than two
/// footprints are left out, so that one sample a pixel does not alias.
void addNoise(int n, const float* x_m, const float* y_m, const float* footprint_m,
              const Spectrum& amplitude, std::uint32_t seed, float* sum);

}  // namespace cf
