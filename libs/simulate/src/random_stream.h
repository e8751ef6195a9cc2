// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <random>
#include <string>

namespace cf {

/// Seed of one purpose ("wobble", "uav1/gnss"): what is drawn for one never moves another.
std::uint64_t streamSeed(std::uint64_t seed, const std::string& purpose);

/// A generator whose draws do not depend on how the standard library makes distributions.
class RandomStream {
 public:
  explicit RandomStream(std::uint64_t seed) : engine_(seed) {}
  double uniform(double low = 0, double high = 1) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  double normal();  ///< of mean 0 and standard deviation 1
  int below(int n) { return static_cast<int>(uniform() * n); }
  bool chance(double p) { return uniform() < p; }
  std::uint32_t bits() { return static_cast<std::uint32_t>(engine_()); }

 private:
  std::mt19937_64 engine_;
};

/// A smooth random process of mean 0 and standard deviation 1: a sum of sinusoids spread evenly
/// over the band from 0 to 1 / (2 time) Hz, so that values `time` apart are uncorrelated.
class SmoothNoise {
 public:
  SmoothNoise(std::uint64_t seed, double time_s);
  double at(double t_s) const;

 private:
  static constexpr int kTerms = 24;
  double frequency_[kTerms], phase_[kTerms];  // rad/s, rad
};

}  // namespace cf
