// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "scene_impl.h"
#include "texture_solids.h"

namespace cf {
namespace {

// Of a white surface: sunlight at right angles, light of the open sky, light from the ground.
const Tint kSun = {1.08F, 1.2F, 1.28F}, kSky = {.34F, .29F, .25F}, kBounce = {.05F, .06F, .07F};
const Tint kHaze = {.75F, .68F, .62F};  // where a ray meets nothing

}  // namespace

void Scene::Impl::paintPlant(const Plant& plant, std::size_t i, const Samples& s,
                             Fragments& fragments) const {
  const Eigen::Vector3f p(s.x[i], s.y[i], s.z[i]);
  const float out = (plant.inverse_shape * (p - plant.centre)).norm();
  // Little light gets down between the boughs.
  const float open = std::clamp((out - 0.45F) / 0.5F, 0.0F, 1.0F);
  fragments.add(Material::kFoliage, i, p.x() + 0.7F * p.z(), p.y() - 0.6F * p.z(), s.footprint[i],
                1, (0.4F + 0.75F * open) * plant.tint);
}

void Scene::Impl::shade(Samples& s) const {
  thread_local Fragments fragments;
  fragments.clear();
  for (std::size_t i = 0; i < static_cast<std::size_t>(s.n); ++i) {
    s.blue[i] = s.green[i] = s.red[i] = s.sun[i] = 0;
    if (s.t[i] < 0) continue;
    const std::uint32_t object = s.object[i];
    if (object == 0) {
      s.sun[i] = std::max(0.0F, terrain_.normal(s.x[i], s.y[i]).dot(to_sun_));
      ground_paint_.paint(i, s.x[i], s.y[i], s.footprint[i], fragments);
      continue;
    }
    s.sun[i] =
        std::max(0.0F, s.nx[i] * to_sun_.x() + s.ny[i] * to_sun_.y() + s.nz[i] * to_sun_.z());
    if (const Plant* plant = plantOf(object)) {
      paintPlant(*plant, i, s, fragments);
    } else {
      paintPart(i, parts_[object - 1], {s.x[i], s.y[i], s.z[i]}, s.footprint[i], fragments);
    }
  }
  castShadows(s);
  fragments.paint(texture_seed_, s);
  for (std::size_t i = 0; i < static_cast<std::size_t>(s.n); ++i) {
    if (s.t[i] < 0) {
      s.blue[i] = kHaze.blue, s.green[i] = kHaze.green, s.red[i] = kHaze.red;
      continue;
    }
    const float sky = 0.5F + 0.5F * s.nz[i];
    s.blue[i] *= s.sun[i] * kSun.blue + sky * kSky.blue + (1 - sky) * kBounce.blue;
    s.green[i] *= s.sun[i] * kSun.green + sky * kSky.green + (1 - sky) * kBounce.green;
    s.red[i] *= s.sun[i] * kSun.red + sky * kSky.red + (1 - sky) * kBounce.red;
  }
}

}  // namespace cf
