// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "texture_materials.h"

#include <algorithm>

#include "texture_noise.h"

namespace cf {
namespace {

struct Look {
  Spectrum brightness;  ///< relative, by octave from 20 m down to 1 cm
  Spectrum hue;
  Tint hue_shift;    ///< relative change of each channel for hue = 1
  float cracks = 0;  ///< loss of light in them
};

// Amplitudes by octave: 20.5 m, 10.2, 5.1, 2.6, 1.3, 0.64, 0.32, 0.16, 0.08, 0.04, 0.02, 0.01.
const std::array<Look, kMaterials> kLooks = {{
    {{.05F, .06F, .07F, .08F, .08F, .1F, .14F, .2F, .27F, .3F, .3F, .28F},
     {.1F, .1F, .1F, .12F, .12F, .1F, .1F, .1F, .1F},
     {-.2F, .1F, .6F},
     0},
    {{.08F, .1F, .12F, .14F, .14F, .16F, .2F, .22F, .22F, .22F, .2F, .18F},
     {.15F, .15F, .15F, .2F, .2F, .15F, .15F, .12F, .1F},
     {.1F, .1F, .7F},
     0},
    {{.05F, .06F, .07F, .08F, .1F, .12F, .14F, .16F, .18F, .18F, .18F, .16F},
     {.1F, .1F, .1F, .1F, .1F, .1F},
     {-.3F, 0, .2F},
     0},
    {{.05F, .05F, .05F, .05F, .06F, .06F, .05F, .05F, .07F, .1F, .14F, .16F},
     {.05F, .05F, .05F},
     {-.15F, 0, .1F},
     .45F},
    {{.03F, .04F, .05F, .05F, .05F, .05F, .05F, .06F, .06F, .08F, .09F, .1F},
     {.05F, .05F, .05F, .05F},
     {-.2F, 0, .15F},
     0},
    {{.04F, .05F, .06F, .07F, .08F, .09F, .1F, .14F, .2F, .24F, .24F, .2F},
     {.05F, .05F, .05F, .05F, .05F, .05F, .1F, .1F, .1F, .1F},
     {-.3F, 0, .3F},
     0},
    {{0, .04F, .06F, .08F, .09F, .09F, .08F, .07F, .06F, .06F, .06F, .05F},
     {0, .1F, .1F, .12F, .12F, .1F, .08F, .06F, .05F},
     {.5F, .3F, -.3F},
     0},
    {{0, .02F, .03F, .04F, .05F, .05F, .04F, .04F, .05F, .06F, .06F, .06F},
     {0, .05F, .05F, .05F},
     {-.2F, 0, .1F},
     0},
    {{.04F, .06F, .08F, .09F, .09F, .08F, .08F, .08F, .1F, .12F, .12F, .1F},
     {0, .08F, .08F, .08F, .08F},
     {-.3F, 0, .2F},
     0},
    {{0, 0, .06F, .1F, .14F, .18F, .22F, .28F, .3F, .28F, .24F, .2F},
     {0, 0, .12F, .12F, .12F, .14F, .14F, .14F, .1F},
     {-.2F, .1F, .5F},
     0},
    {},
}};

}  // namespace

void Fragments::clear() {
  for (auto& list : lists_) {
    list.sample.clear();
    list.u.clear();
    list.v.clear();
    list.footprint.clear();
    list.share.clear();
    list.tint.clear();
  }
}

void Fragments::add(Material material, std::size_t sample, float u, float v, float footprint,
                    float share, const Tint& tint) {
  if (share <= 0) return;
  List& list = lists_[static_cast<std::size_t>(material)];
  list.sample.push_back(sample);
  list.u.push_back(u);
  list.v.push_back(v);
  list.footprint.push_back(footprint);
  list.share.push_back(share);
  list.tint.push_back(tint);
}

void Fragments::paint(std::uint32_t seed, Samples& samples) {
  for (std::size_t m = 0; m < lists_.size(); ++m) {
    const List& list = lists_[m];
    const Look& look = kLooks[m];
    const std::size_t n = list.sample.size();
    const auto count = static_cast<int>(n);
    const std::uint32_t own_seed = hash2(seed, static_cast<std::uint32_t>(m));
    brightness_.assign(n, 1.0F);
    hue_.assign(n, 0.0F);
    addNoise(count, list.u.data(), list.v.data(), list.footprint.data(), look.brightness, own_seed,
             brightness_.data());
    addNoise(count, list.u.data(), list.v.data(), list.footprint.data(), look.hue, own_seed + 1,
             hue_.data());
    if (look.cracks > 0) {
      // Lines where a wandering noise passes through zero.
      static const Spectrum kWander = {0, 0, 1, .35F, .2F, .1F, .06F};
      std::vector<float> wander(n, 0.0F);
      addNoise(count, list.u.data(), list.v.data(), list.footprint.data(), kWander, own_seed + 2,
               wander.data());
      for (std::size_t i = 0; i < n; ++i) {
        constexpr float kHalfWidth = 0.012F;
        const float spread = kHalfWidth + 0.4F * list.footprint[i];
        const float near_line = 1 - std::abs(wander[i]) / spread;
        if (near_line > 0) brightness_[i] *= 1 - look.cracks * near_line * kHalfWidth / spread;
      }
    }
    for (std::size_t i = 0; i < n; ++i) {
      const float value = list.share[i] * std::max(0.12F, brightness_[i]);
      const std::size_t s = list.sample[i];
      samples.blue[s] += value * list.tint[i].blue * (1 + look.hue_shift.blue * hue_[i]);
      samples.green[s] += value * list.tint[i].green * (1 + look.hue_shift.green * hue_[i]);
      samples.red[s] += value * list.tint[i].red * (1 + look.hue_shift.red * hue_[i]);
    }
  }
}

}  // namespace cf
