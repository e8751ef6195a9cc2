// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "scene_plan.h"
#include "terrain.h"
#include "texture_materials.h"

namespace cf {

/// What a flat part of a building or car looks like.
enum class Finish { kPlain, kWall, kTiledRoof, kFlatRoof, kSolar, kGlass, kBrick };

/// A flat part with its own texture axes: u along it, v up or down its slope [m].
struct Part {
  Finish finish = Finish::kPlain;
  Eigen::Vector3f origin, u, v;
  Tint tint;
  float width = 0, height = 0;  ///< of a wall
  std::uint32_t seed = 0;
};

/// Triangles of all that is built.
struct Solids {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::uint32_t> corners;  ///< three a triangle
  std::vector<std::uint32_t> part_of;  ///< of each triangle
  std::vector<Part> parts;
};

void addBuilding(const BuildingPlan& plan, const Eigen::Rotation2Dd& turn, const Terrain& terrain,
                 Solids& solids);
void addCar(const CarPlan& plan, const Eigen::Rotation2Dd& turn, const Terrain& terrain,
            Solids& solids);

}  // namespace cf
