// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "cf/base/options.h"

namespace cf {

/// [scene]: what stands in the simulated world. Lengths in metres.
struct SceneOptions {
  int seed = 0;                   ///< of the world; 0 = [simulation] seed
  std::string area;               ///< "W, S, E, N" of the world; empty: what the photos may see
  std::string changes;            ///< "raze E N, raise E N METRES, build E N WIDTH DEPTH HEIGHT"
  std::string terrain = "hills";  ///< flat | hills
  double relief_m = 8;            ///< from the lowest to the highest ground
  double building_density = 25;   ///< per hectare
  double tree_density = 40;       ///< per hectare
  double road_spacing_m = 70;     ///< 0 = no roads
  double crop_share = 0.1;        ///< of the ground under repetitive rows
  double blank_share = 0;         ///< of the ground without texture (water, snow)
  double sun_azimuth_deg = 220;   ///< where the light comes from, from north clockwise
  double sun_elevation_deg = 50;

  void visit(OptionVisitor& v);
};

/// A ray's first hit.
struct SurfaceHit {
  double distance = 0;  ///< in units of the ray's direction
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  std::uint32_t object = 0;  ///< changes where one object ends and another begins
};

/// A world of triangles and procedural textures above an area of the ENU plane, made from a seed.
/// Nothing in it changes after construction: safe to read from several threads.
class Scene {
 public:
  /// `area` [m] is what the photos may see, margins included.
  Scene(const SceneOptions& options, const Eigen::AlignedBox2d& area, std::uint64_t seed);
  ~Scene();
  Scene(Scene&&) noexcept;

  std::optional<SurfaceHit> hit(const Eigen::Vector3d& origin,
                                const Eigen::Vector3d& direction) const;
  /// Linear colour (BGR, 0 to 1, sun and shadow included) of a hit seen with a footprint of that
  /// size [m]: texture detail finer than it is averaged, not aliased.
  Eigen::Vector3f radiance(const SurfaceHit& hit, double footprint_m) const;
  /// Height of the topmost surface [m] (roof, crown or ground) and of the bare ground.
  double surfaceHeight(double x, double y) const;
  double groundHeight(double x, double y) const;
  const Eigen::AlignedBox2d& area() const;

  class Impl;
  /// For the photographer.
  const Impl& impl() const;

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace cf
