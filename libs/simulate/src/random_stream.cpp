// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "random_stream.h"

#include <cmath>

namespace cf {
namespace {

/// Spreads every bit of the input over the output (the finaliser of SplitMix64).
std::uint64_t mixed(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15ULL;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31);
}

}  // namespace

std::uint64_t streamSeed(std::uint64_t seed, const std::string& purpose) {
  std::uint64_t hash = mixed(seed);
  for (const char c : purpose) hash = mixed(hash ^ static_cast<unsigned char>(c));
  return hash;
}

double RandomStream::normal() {
  // Box and Muller; 1 - u is never 0.
  const double radius = std::sqrt(-2 * std::log(1 - uniform(0, 1)));
  return radius * std::cos(uniform(0, 2 * M_PI));
}

SmoothNoise::SmoothNoise(std::uint64_t seed, double time_s) {
  RandomStream random(seed);
  for (int k = 0; k < kTerms; ++k) {
    const double share = (k + random.uniform(0, 1)) / kTerms;
    frequency_[k] = M_PI * share / time_s;
    phase_[k] = random.uniform(0, 2 * M_PI);
  }
}

double SmoothNoise::at(double t_s) const {
  double sum = 0;
  for (int k = 0; k < kTerms; ++k) sum += std::cos(frequency_[k] * t_s + phase_[k]);
  return sum * std::sqrt(2.0 / kTerms);
}

}  // namespace cf
