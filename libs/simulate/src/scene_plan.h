// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "cf/simulate/scene.h"

namespace cf {

enum class LandUse { kHomes, kBusiness, kPark, kCrop, kBlank };

/// The ground between four roads, a rectangle of the plan.
struct Block {
  Eigen::AlignedBox2d box;  ///< kerb to kerb
  LandUse use = LandUse::kPark;
  std::uint32_t seed = 0;
};

enum class Roof { kFlat, kGable, kHip };

/// A house or hall: a rectangle of the plan with walls and a roof.
struct BuildingPlan {
  Eigen::AlignedBox2d box;
  bool ridge_along_x = true;
  double eaves_m = 5;  ///< of the walls above the ground
  double pitch = 0.7;  ///< slope of the roof
  Roof roof = Roof::kGable;
  bool home = true;
  std::uint32_t seed = 0;
};

enum class Greenery { kBroadleaf, kConifer, kHedge };

struct PlantPlan {
  Greenery kind = Greenery::kBroadleaf;
  Eigen::Vector2d place;
  Eigen::Vector3d size_m;  ///< half extents: along, across, up
  double turn = 0;         ///< in the plan [rad]
  double foot_m = 0;       ///< bare trunk below the crown
  std::uint32_t seed = 0;
};

struct CarPlan {
  Eigen::Vector2d place;
  double turn = 0;
  std::uint32_t seed = 0;
};

enum class Paint { kPaving, kGravel, kSoil, kParking, kPatch, kPool, kBed };

/// A rectangle painted on the ground.
struct Decal {
  Eigen::AlignedBox2d box;
  Paint paint = Paint::kPaving;
  std::uint32_t seed = 0;
};

/// Who stands where. The plan's own axes are turned against east and north, so that streets run
/// along neither; p_scene = turn * p_plan.
struct TownPlan {
  double angle = 0;
  Eigen::Rotation2Dd turn{0};
  bool roads = true;
  double half_road_m = 3.2, kerb_m = 5;  ///< from the middle of a road
  std::vector<double> lines_x, lines_y;  ///< middles of the roads, ascending
  std::vector<Block> blocks;             ///< column by column of lines_x
  std::vector<BuildingPlan> buildings;
  std::vector<PlantPlan> plants;
  std::vector<CarPlan> cars;
  std::vector<Decal> decals;

  int blocksAcross() const { return static_cast<int>(lines_y.size()) - 1; }
};

/// Roads, blocks and what is in them over a scene of the given half extent [m].
TownPlan planTown(const SceneOptions& options, const Eigen::Vector2d& half_extent_m,
                  std::uint64_t seed);

/// Trees, hedges and cars between what stands already.
void plantTown(const SceneOptions& options, std::uint64_t seed, TownPlan& plan);

}  // namespace cf
