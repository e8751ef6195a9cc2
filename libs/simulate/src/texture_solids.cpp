// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "texture_solids.h"

#include <algorithm>
#include <cmath>

#include "texture_patterns.h"

namespace cf {
namespace {

const Tint kPane = {.075F, .06F, .05F}, kFrame = {.55F, .57F, .58F};

/// Windows in rows under the eaves; v counts downwards.
Tint facade(const Part& part, float u, float v, float fp) {
  constexpr float kStorey_m = 2.8F, kBay_m = 2.7F;
  const float bay = part.width / std::max(1.0F, std::round(part.width / kBay_m));
  const float window =
      bars(u - 0.27F * bay, bay, 0.46F * bay, fp) * bars(v - 0.55F, kStorey_m, 1.4F, fp);
  const float pane = bars(u - 0.27F * bay - 0.08F, bay, 0.46F * bay - 0.16F, fp) *
                     bars(v - 0.63F, kStorey_m, 1.24F, fp);
  const float curtain = 1 + cellNoise(u, v, bay, kStorey_m, fp, part.seed);
  const Tint wall = mix(part.tint, kFrame, window);
  return mix(wall, (0.5F + curtain) * kPane, pane);
}

Tint tiles(const Part& part, float u, float v, float fp) {
  constexpr float kRow_m = 0.34F, kColumn_m = 0.25F;
  const float row = std::floor(v / kRow_m);
  const float shifted = u + 0.5F * kColumn_m * (row - 2 * std::floor(row / 2));
  const float shade =
      1 - 0.55F * bars(v, kRow_m, 0.05F, fp) - 0.35F * bars(shifted, kColumn_m, 0.04F, fp);
  const float own = 1 + 0.2F * cellNoise(shifted, v, kColumn_m, kRow_m, fp, part.seed);
  return 1.12F * shade * own * part.tint;
}

Tint deck(const Part& part, float u, float v, float fp) {
  const float seam = bars(u, 1.05F, 0.05F, fp) + 0.6F * bars(v, 7.5F, 0.05F, fp);
  const float sheet = 1 + 0.06F * cellNoise(u, v, 1.05F, 7.5F, fp, part.seed);
  return sheet * (1 - 0.3F * seam) * part.tint;
}

Tint solar(const Part& part, float u, float v, float fp) {
  const float frame = std::min(1.0F, bars(u, 1.0F, 0.05F, fp) + bars(v, 1.65F, 0.05F, fp));
  const float wires = bars(u, 0.16F, 0.012F, fp) + bars(v, 0.16F, 0.012F, fp);
  return mix((1 + 2 * wires) * part.tint, kFrame, 0.6F * frame);
}

Tint pane(const Part& part, float u, float v, float fp) {
  constexpr float kRim_m = 0.07F;
  const float glass =
      inside(u, kRim_m, part.width - kRim_m, fp) * inside(v, kRim_m, part.height - kRim_m, fp);
  return mix(0.5F * kFrame, part.tint, glass);
}

Tint brick(const Part& part, float u, float v, float fp) {
  const float joint = bars(v, 0.075F, 0.012F, fp) + bars(u, 0.24F, 0.012F, fp);
  return (1 + 0.6F * joint) * (1 + 0.2F * cellNoise(u, v, 0.24F, 0.075F, fp, part.seed)) *
         part.tint;
}

}  // namespace

void paintPart(std::size_t sample, const Part& part, const Eigen::Vector3f& position,
               float footprint, Fragments& fragments) {
  const Eigen::Vector3f p = position - part.origin;
  const float u = p.dot(part.u), v = p.dot(part.v);
  // No two parts show the same piece of noise.
  const float away_u = u + static_cast<float>(part.seed & 0xFFFU);
  const float away_v = v + static_cast<float>(part.seed >> 12 & 0xFFFU);
  auto add = [&](Material material, const Tint& tint) {
    fragments.add(material, sample, away_u, away_v, footprint, 1, tint);
  };
  switch (part.finish) {
    case Finish::kPlain:
      return add(Material::kPlaster, part.tint);
    case Finish::kWall:
      return add(Material::kPlaster, facade(part, u, v, footprint));
    case Finish::kTiledRoof:
      return add(Material::kTiles, tiles(part, u, v, footprint));
    case Finish::kFlatRoof:
      return add(Material::kFlatRoof, deck(part, u, v, footprint));
    case Finish::kSolar:
      return add(Material::kPlaster, solar(part, u, v, footprint));
    case Finish::kGlass:
      return add(Material::kSmooth, pane(part, u, v, footprint));
    case Finish::kBrick:
      return add(Material::kPlaster, brick(part, u, v, footprint));
  }
}

}  // namespace cf
