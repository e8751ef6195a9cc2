// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "scene_impl.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "cf/base/error.h"
#include "random_stream.h"
#include "scene_changes.h"
#include "texture_noise.h"

namespace cf {
namespace {

/// Built and planted beyond the area: seen, and casting shadows, from aside.
constexpr double kMargin_m = 40;

Eigen::Vector3f sunDirection(const SceneOptions& options) {
  const double azimuth = options.sun_azimuth_deg * M_PI / 180;
  const double elevation = options.sun_elevation_deg * M_PI / 180;
  return Eigen::Vector3d(std::sin(azimuth) * std::cos(elevation),
                         std::cos(azimuth) * std::cos(elevation), std::sin(elevation))
      .cast<float>();
}

Eigen::Vector2d halfExtent(const Eigen::AlignedBox2d& area) {
  if (area.isEmpty()) throw UsageError("the scene's area is empty");
  return area.sizes() / 2 + Eigen::Vector2d::Constant(kMargin_m);
}

TownPlan planAndPlant(const SceneOptions& options, const Eigen::AlignedBox2d& area,
                      std::uint64_t seed) {
  TownPlan plan = planTown(options, halfExtent(area), seed);
  plantTown(options, seed, plan);
  applyChanges(options.changes, area.center(), plan);
  return plan;
}

}  // namespace

Scene::Impl::Impl(const SceneOptions& options, const Eigen::AlignedBox2d& area, std::uint64_t seed)
    : area_(area),
      offset_(area.center().x(), area.center().y(), 0),
      texture_seed_(
          hash2(static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32))),
      // Beyond the margin there is bare ground only, so that no oblique ray looks over its edge.
      terrain_(options.terrain == "hills", options.relief_m,
               halfExtent(area) + Eigen::Vector2d::Constant(200), seed),
      to_sun_(sunDirection(options)),
      plan_(planAndPlant(options, area, seed)),
      ground_paint_(plan_),
      // One thread builds: the tree, and so which of two triangles a ray through their common edge
      // hits, does not depend on the number of cores.
      device_(rtcNewDevice("threads=1")) {
  if (!device_) throw RunError("Embree does not start on this machine");
  scene_.reset(rtcNewScene(device_.get()));
  rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);
  buildMeshes();
  buildPlants(seed);
  rtcCommitScene(scene_.get());
  // Embree holds all of oneTBB to the most threads that any of its devices asks for: without a
  // second one, photos too would be taken by a single thread.
  unlimited_device_.reset(rtcNewDevice(nullptr));
  if (!unlimited_device_) throw RunError("Embree does not start on this machine");
}

bool Scene::Impl::isNear(const Eigen::Vector2d& place) const {
  return (place.cwiseAbs() - halfExtent(area_)).maxCoeff() < 0;
}

void Scene::Impl::buildMeshes() {
  for (int r = 0; r < terrain_.rows(); ++r) {
    for (int c = 0; c < terrain_.columns(); ++c) ground_.vertices.push_back(terrain_.vertex(c, r));
  }
  ground_.corners = terrain_.triangles();
  attach(scene_.get(), ground_, 0);

  Solids solids;
  for (const auto& building : plan_.buildings) {
    if (isNear(plan_.turn * building.box.center())) {
      addBuilding(building, plan_.turn, terrain_, solids);
    }
  }
  for (const auto& car : plan_.cars) {
    if (isNear(plan_.turn * car.place)) addCar(car, plan_.turn, terrain_, solids);
  }
  built_ = {std::move(solids.vertices), std::move(solids.corners)};
  parts_ = std::move(solids.parts);
  part_of_ = std::move(solids.part_of);
  if (!parts_.empty()) attach(scene_.get(), built_, 1);
}

void Scene::Impl::buildPlants(std::uint64_t seed) {
  constexpr int kBroadleaves = 7, kConifers = 2, kHedges = 2;
  const int first[] = {0, kBroadleaves, kBroadleaves + kConifers,
                       kBroadleaves + kConifers + kHedges};
  for (int k = 0; k < first[3]; ++k) {
    const int kind = k < first[1] ? 0 : (k < first[2] ? 1 : 2);
    CrownMesh crown = makeCrown(static_cast<Greenery>(kind), seed * 64 + static_cast<unsigned>(k));
    crowns_.push_back({std::move(crown.vertices), std::move(crown.corners)});
    crown_scenes_.emplace_back(rtcNewScene(device_.get()));
    rtcSetSceneFlags(crown_scenes_.back().get(), RTC_SCENE_FLAG_ROBUST);
    attach(crown_scenes_.back().get(), crowns_.back(), 0);
    rtcCommitScene(crown_scenes_.back().get());
  }
  for (const auto& planned : plan_.plants) {
    const Eigen::Vector2d place = plan_.turn * planned.place;
    if (!isNear(place)) continue;
    RandomStream dice(planned.seed);
    const int kind = static_cast<int>(planned.kind);
    Plant plant;
    plant.crown = first[kind] + dice.below(first[kind + 1] - first[kind]);
    plant.centre = Eigen::Vector3d(place.x(), place.y(),
                                   terrain_.height(place.x(), place.y()) + planned.foot_m +
                                       0.95 * planned.size_m.z())
                       .cast<float>();
    const double turn = plan_.angle + planned.turn;
    plant.shape =
        (Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()) * Eigen::Scaling(planned.size_m))
            .matrix()
            .cast<float>();
    plant.inverse_shape = plant.shape.inverse();
    const Tint dark = {.03F, .085F, .045F}, light = {.045F, .15F, .105F};
    const Tint conifer = {.035F, .07F, .04F};
    plant.tint =
        mix(planned.kind == Greenery::kConifer ? conifer : dark, light,
            static_cast<float>(dice.uniform(0, planned.kind == Greenery::kConifer ? 0.3 : 1)));
    RTCGeometry instance = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(instance,
                                 crown_scenes_[static_cast<std::size_t>(plant.crown)].get());
    Eigen::Matrix<float, 3, 4> transform;
    transform << plant.shape, plant.centre;
    rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, transform.data());
    rtcCommitGeometry(instance);
    rtcAttachGeometryByID(scene_.get(), instance, static_cast<unsigned>(2 + plants_.size()));
    rtcReleaseGeometry(instance);
    plants_.push_back(plant);
  }
}

void Scene::Impl::attach(RTCScene scene, const Mesh& mesh, unsigned id) {
  RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* v = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                        RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                        mesh.vertices.size()));
  for (const auto& p : mesh.vertices) v = std::copy(p.data(), p.data() + 3, v);
  auto* c = static_cast<std::uint32_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(std::uint32_t), mesh.corners.size() / 3));
  std::copy(mesh.corners.begin(), mesh.corners.end(), c);
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene, geometry, id);
  rtcReleaseGeometry(geometry);
}

}  // namespace cf
