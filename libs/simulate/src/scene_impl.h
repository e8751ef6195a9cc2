// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <embree3/rtcore.h>

#include "cf/simulate/scene.h"
#include "scene_samples.h"
#include "terrain.h"

namespace cf {

/// The inside of a scene. Its coordinates have their origin in the middle of the area, so that
/// Embree's floats are good to some hundredths of a millimetre.
class Scene::Impl {
 public:
  Impl(const SceneOptions& options, const Eigen::AlignedBox2d& area, std::uint64_t seed);
  ~Impl();
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  /// First hits of all rays: t, position, normal, object.
  void trace(Samples& samples) const;
  /// sun and colour of all hits.
  void shade(Samples& samples) const;
  /// One ray with its hit in double precision, scene coordinates.
  std::optional<SurfaceHit> hit(const Eigen::Vector3d& origin,
                                const Eigen::Vector3d& direction) const;

  const Terrain& terrain() const { return terrain_; }
  const Eigen::AlignedBox2d& area() const { return area_; }
  /// World coordinates of the scene's origin.
  const Eigen::Vector3d& offset() const { return offset_; }

 private:
  void addGround();
  void castShadows(Samples& samples) const;

  Eigen::AlignedBox2d area_;
  Eigen::Vector3d offset_;
  std::uint64_t seed_;
  Terrain terrain_;
  Eigen::Vector3f to_sun_;
  RTCDevice device_ = nullptr;
  RTCScene scene_ = nullptr;
};

}  // namespace cf
