// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "texture_noise.h"

#include <algorithm>

#include "cf/base/instruction_sets.h"

namespace cf {
namespace {

/// One octave. (c, s) turns the lattice, so that octaves do not share its directions.
CF_CLONES void addOctave(int n, const float* x, const float* y, const float* footprint,
                         float spacing, float amplitude, float c, float s, std::uint32_t seed,
                         float* sum) {
  const float per_metre = 1 / spacing;
  for (int i = 0; i < n; ++i) {
    const float u = (c * x[i] - s * y[i]) * per_metre, v = (s * x[i] + c * y[i]) * per_metre;
    const int iu = floorInt(u), iv = floorInt(v);
    const float fu = u - static_cast<float>(iu), fv = v - static_cast<float>(iv);
    const float wu = fu * fu * (3 - 2 * fu), wv = fv * fv * (3 - 2 * fv);
    const std::uint32_t a0 = static_cast<std::uint32_t>(iu) * 0x9E3779B1U;
    const std::uint32_t a1 = a0 + 0x9E3779B1U;
    const std::uint32_t b0 = static_cast<std::uint32_t>(iv) * 0x85EBCA77U + seed;
    const std::uint32_t b1 = b0 + 0x85EBCA77U;
    std::uint32_t h00 = a0 ^ b0, h10 = a1 ^ b0, h01 = a0 ^ b1, h11 = a1 ^ b1;
    h00 = (h00 ^ (h00 >> 15)) * 0x2C1B3C6DU;
    h10 = (h10 ^ (h10 >> 15)) * 0x2C1B3C6DU;
    h01 = (h01 ^ (h01 >> 15)) * 0x2C1B3C6DU;
    h11 = (h11 ^ (h11 >> 15)) * 0x2C1B3C6DU;
    // The top bits of a product are the well mixed ones; as signed numbers they are in ±2^31.
    const float g00 = static_cast<float>(static_cast<std::int32_t>(h00 ^ (h00 << 13)));
    const float g10 = static_cast<float>(static_cast<std::int32_t>(h10 ^ (h10 << 13)));
    const float g01 = static_cast<float>(static_cast<std::int32_t>(h01 ^ (h01 << 13)));
    const float g11 = static_cast<float>(static_cast<std::int32_t>(h11 ^ (h11 << 13)));
    const float top = g00 + wu * (g10 - g00), bottom = g01 + wu * (g11 - g01);
    const float value = (top + wv * (bottom - top)) * 0x1p-31F;
    float t = spacing / (1.5F * footprint[i]) - 1;
    t = t < 0 ? 0 : t;
    t = t > 1 ? 1 : t;
    sum[i] += amplitude * (t * t * (3 - 2 * t)) * value;
  }
}

}  // namespace

void addNoise(int n, const float* x_m, const float* y_m, const float* footprint_m,
              const Spectrum& amplitude, std::uint32_t seed, float* sum) {
  if (n == 0) return;
  const float finest = *std::min_element(footprint_m, footprint_m + n);
  float spacing = kWidestSpacing_m, c = 1, s = 0;
  for (int k = 0; k < kOctaves && spacing > finest; ++k, spacing /= 2) {
    if (amplitude[static_cast<std::size_t>(k)] != 0) {
      addOctave(n, x_m, y_m, footprint_m, spacing, amplitude[static_cast<std::size_t>(k)], c, s,
                hash2(seed, static_cast<std::uint32_t>(k)), sum);
    }
    const float c1 = 0.8F * c - 0.6F * s;
    s = 0.6F * c + 0.8F * s;
    c = c1;
  }
}

}  // namespace cf
