// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "scene_samples.h"

namespace cf {

/// What a surface is made of: how its brightness and hue vary with position.
enum class Material {
  kLawn,
  kMeadow,
  kSoil,
  kAsphalt,
  kConcrete,
  kGravel,
  kTiles,
  kPlaster,
  kFlatRoof,
  kFoliage,
  kSmooth,  ///< no texture at all: water, snow, paint, glass
};
constexpr int kMaterials = 11;

/// Linear reflectance, blue, green, red.
struct Tint {
  float blue = 0, green = 0, red = 0;
};
inline Tint operator*(float f, const Tint& t) { return {f * t.blue, f * t.green, f * t.red}; }
inline Tint mix(const Tint& a, const Tint& b, float share_of_b) {
  return {a.blue + share_of_b * (b.blue - a.blue), a.green + share_of_b * (b.green - a.green),
          a.red + share_of_b * (b.red - a.red)};
}

/// Pieces of surface that samples see, sorted by material, so that their noise is computed for many
/// at once. A sample sees two or more where materials meet within its footprint.
class Fragments {
 public:
  void clear();
  /// Sample `sample` sees `material` at (u, v) on it [m], over `share` of its footprint.
  void add(Material material, std::size_t sample, float u, float v, float footprint, float share,
           const Tint& tint);
  /// Adds every fragment's reflectance to its sample's colour.
  void paint(std::uint32_t seed, Samples& samples);

 private:
  struct List {
    std::vector<std::size_t> sample;
    std::vector<float> u, v, footprint, share;
    std::vector<Tint> tint;
  };
  std::array<List, kMaterials> lists_;
  std::vector<float> brightness_, hue_;
};

}  // namespace cf
