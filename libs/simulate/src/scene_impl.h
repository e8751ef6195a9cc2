// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <embree3/rtcore.h>

#include <memory>
#include <optional>
#include <vector>

#include "buildings.h"
#include "cf/simulate/scene.h"
#include "scene_plan.h"
#include "scene_samples.h"
#include "terrain.h"
#include "texture_ground.h"
#include "trees.h"

namespace cf {

/// The inside of a scene. Its coordinates have their origin in the middle of the area, so that
/// Embree's floats are good to some hundredths of a millimetre.
///
/// Objects: 0 the ground, then the parts of solids, then the plants.
class Scene::Impl {
 public:
  Impl(const SceneOptions& options, const Eigen::AlignedBox2d& area, std::uint64_t seed);
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  /// First hits of all rays: t, position, normal, object.
  void trace(Samples& samples) const;
  /// sun and colour of all hits.
  void shade(Samples& samples) const;
  /// One ray with its hit in double precision, scene coordinates.
  std::optional<SurfaceHit> hit(const Eigen::Vector3d& origin,
                                const Eigen::Vector3d& direction) const;

  bool isPlant(std::uint32_t object) const { return object > parts_.size(); }
  const Terrain& terrain() const { return terrain_; }
  const Eigen::AlignedBox2d& area() const { return area_; }
  /// World coordinates of the scene's origin.
  const Eigen::Vector3d& offset() const { return offset_; }

 private:
  struct Mesh {
    std::vector<Eigen::Vector3f> vertices;
    std::vector<std::uint32_t> corners;
  };
  /// A crown where it stands.
  struct Plant {
    int crown = 0;
    Eigen::Vector3f centre;
    Eigen::Matrix3f shape;          ///< crown to scene, without the centre
    Eigen::Matrix3f inverse_shape;  ///< its transpose takes normals to the scene
    Tint tint;
  };
  struct ReleaseDevice {
    void operator()(RTCDevice d) const { rtcReleaseDevice(d); }
  };
  struct ReleaseScene {
    void operator()(RTCScene s) const { rtcReleaseScene(s); }
  };
  using DevicePtr = std::unique_ptr<std::remove_pointer_t<RTCDevice>, ReleaseDevice>;
  using ScenePtr = std::unique_ptr<std::remove_pointer_t<RTCScene>, ReleaseScene>;

  bool isNear(const Eigen::Vector2d& place) const;
  void buildMeshes();
  void buildPlants(std::uint64_t seed);
  void attach(RTCScene scene, const Mesh& mesh, unsigned id);
  std::uint32_t objectOf(unsigned geometry, unsigned primitive, unsigned instance) const;
  const Plant* plantOf(std::uint32_t object) const;
  void castShadows(Samples& samples) const;
  void paintPlant(const Plant& plant, std::size_t i, const Samples& samples,
                  Fragments& fragments) const;

  Eigen::AlignedBox2d area_;
  Eigen::Vector3d offset_;
  std::uint32_t texture_seed_;
  Terrain terrain_;
  Eigen::Vector3f to_sun_;
  TownPlan plan_;
  GroundPaint ground_paint_;
  Mesh ground_, built_;
  std::vector<Part> parts_;
  std::vector<std::uint32_t> part_of_;  ///< of each triangle of built_
  std::vector<Mesh> crowns_;
  std::vector<Plant> plants_;
  DevicePtr device_;            ///< builds, on one thread
  DevicePtr unlimited_device_;  ///< lifts that limit again
  std::vector<ScenePtr> crown_scenes_;
  ScenePtr scene_;
};

}  // namespace cf
