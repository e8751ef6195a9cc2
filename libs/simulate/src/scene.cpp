// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/simulate/scene.h"

#include <cmath>

#include "cf/base/error.h"
#include "scene_impl.h"

namespace cf {

void SceneOptions::visit(OptionVisitor& v) {
  v.integer("seed", seed, {0, 2147483647},
            "of the world: with the same seed and area, the same; 0 = [simulation] seed");
  v.text("area", area,
         "W, S, E, N: where the world is made [m]; empty: what the photos may see, by a margin");
  v.text("changes", changes,
         "what differs from the world of that seed, comma separated: raze E N (the building "
         "there), raise E N METRES, build E N WIDTH DEPTH HEIGHT (a hall)");
  v.choice("terrain", terrain, {"flat", "hills"}, "shape of the ground");
  v.number("relief_m", relief_m, {0, 500}, "hills: from the lowest to the highest ground [m]");
  v.number("building_density", building_density, {0, 60}, "buildings per hectare");
  v.number("tree_density", tree_density, {0, 400}, "trees per hectare");
  v.number("road_spacing_m", road_spacing_m, {0, 1000}, "mean width of a block [m]; 0 = no roads");
  v.number("crop_share", crop_share, {0, 1}, "share of the blocks under repetitive rows");
  v.number("blank_share", blank_share, {0, 1}, "share of the blocks without texture");
  v.number("sun_azimuth_deg", sun_azimuth_deg, {-360, 360},
           "where the light comes from, from north clockwise [deg]");
  v.number("sun_elevation_deg", sun_elevation_deg, {5, 90}, "height of the sun [deg]");
}

Scene::Scene(const SceneOptions& options, const Eigen::AlignedBox2d& area, std::uint64_t seed)
    : impl_(std::make_unique<Impl>(options, area, seed)) {}
Scene::~Scene() = default;
Scene::Scene(Scene&&) noexcept = default;

std::optional<SurfaceHit> Scene::hit(const Eigen::Vector3d& origin,
                                     const Eigen::Vector3d& direction) const {
  auto found = impl_->hit(origin - impl_->offset(), direction);
  if (found) found->position_m += impl_->offset();
  return found;
}

Eigen::Vector3f Scene::radiance(const SurfaceHit& hit, double footprint_m) const {
  Samples one(1);
  const Eigen::Vector3f p = (hit.position_m - impl_->offset()).cast<float>();
  one.t[0] = 1;
  one.x[0] = p.x(), one.y[0] = p.y(), one.z[0] = p.z();
  one.nx[0] = static_cast<float>(hit.normal.x());
  one.ny[0] = static_cast<float>(hit.normal.y());
  one.nz[0] = static_cast<float>(hit.normal.z());
  one.object[0] = hit.object;
  one.footprint[0] = static_cast<float>(footprint_m);
  impl_->shade(one);
  return {one.blue[0], one.green[0], one.red[0]};
}

double Scene::surfaceHeight(double x, double y) const {
  constexpr double kAbove_m = 1000;
  const auto top = hit({x, y, kAbove_m}, -Eigen::Vector3d::UnitZ());
  return top ? top->position_m.z() : groundHeight(x, y);
}

double Scene::groundHeight(double x, double y) const {
  return impl_->terrain().height(x - impl_->offset().x(), y - impl_->offset().y());
}

const Eigen::AlignedBox2d& Scene::area() const { return impl_->area(); }

const Scene::Impl& Scene::impl() const { return *impl_; }

}  // namespace cf
