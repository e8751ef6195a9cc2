// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "random_stream.h"
#include "scene_plan.h"

namespace cf {
namespace {

/// Buildings by block, to look up what stands near a place.
class Neighbourhood {
 public:
  explicit Neighbourhood(const TownPlan& plan) : plan_(plan), of_block_(plan.blocks.size()) {
    for (std::size_t b = 0, block = 0; b < plan.buildings.size(); ++b) {
      // Buildings were made block by block.
      while (!plan.blocks[block].box.contains(plan.buildings[b].box.center())) ++block;
      of_block_[block].push_back(b);
    }
  }
  /// Whether a disc touches no building of the block.
  bool isFree(std::size_t block, const Eigen::Vector2d& place, double radius) const {
    return std::none_of(of_block_[block].begin(), of_block_[block].end(), [&](std::size_t b) {
      return plan_.buildings[b].box.squaredExteriorDistance(place) < radius * radius;
    });
  }

 private:
  const TownPlan& plan_;
  std::vector<std::vector<std::size_t>> of_block_;
};

PlantPlan tree(const Eigen::Vector2d& place, double largest, RandomStream& dice) {
  PlantPlan plant;
  plant.place = place;
  plant.kind = dice.chance(0.17) ? Greenery::kConifer : Greenery::kBroadleaf;
  const double radius = std::min(largest, dice.uniform(1.3, 2.6) * dice.uniform(1, 1.9));
  plant.turn = dice.uniform(0, 2 * M_PI);
  if (plant.kind == Greenery::kConifer) {
    plant.size_m = {0.7 * radius, 0.7 * radius, dice.uniform(1.6, 2.4) * radius};
    plant.foot_m = 0.3;
  } else {
    plant.size_m = {radius * dice.uniform(0.9, 1.1), radius, radius * dice.uniform(0.75, 1.15)};
    plant.foot_m = radius * dice.uniform(0.3, 0.8);
  }
  plant.seed = dice.bits();
  return plant;
}

void addTrees(const Block& block, std::size_t index, double wanted, const Neighbourhood& near,
              RandomStream& dice, TownPlan& plan) {
  const int count = static_cast<int>(wanted + dice.uniform());
  const Eigen::Vector2d size = block.box.sizes();
  for (int k = 0, tries = 0; k < count && tries < 6 * count; ++tries) {
    const Eigen::Vector2d place =
        block.box.min() + Eigen::Vector2d(dice.uniform() * size.x(), dice.uniform() * size.y());
    const double room = block.use == LandUse::kPark ? 5.5 : 3.8;
    PlantPlan plant = tree(place, room, dice);
    if (!near.isFree(index, place, 0.75 * plant.size_m.y() + 0.4)) continue;
    plan.plants.push_back(plant);
    ++k;
    for (int bushes = dice.below(3); bushes > 0; --bushes) {
      PlantPlan bush = plant;
      const double around = dice.uniform(0, 2 * M_PI), away = dice.uniform(1.5, 6);
      bush.place += away * Eigen::Vector2d(std::cos(around), std::sin(around));
      const double radius = dice.uniform(0.4, 1.1);
      bush.kind = Greenery::kBroadleaf;
      bush.size_m = {radius, radius, radius * dice.uniform(0.7, 1)};
      bush.foot_m = -0.5 * radius;
      bush.seed = dice.bits();
      if (block.box.contains(bush.place) && near.isFree(index, bush.place, radius)) {
        plan.plants.push_back(bush);
      }
    }
  }
}

/// Hedges between gardens: down the middle of the block and across it.
void addHedges(const Block& block, std::size_t index, const Neighbourhood& near, RandomStream& dice,
               TownPlan& plan) {
  constexpr double kHalf_m = 3.5;
  for (const bool along_x : {true, false}) {
    const int a = along_x ? 0 : 1, b = 1 - a;
    for (double line = block.box.min()[b] + dice.uniform(12, 22); line < block.box.max()[b] - 8;
         line += dice.uniform(14, 24)) {
      for (double at = block.box.min()[a] + 1.5 + kHalf_m; at < block.box.max()[a] - kHalf_m;
           at += 2 * kHalf_m - 0.2) {
        Eigen::Vector2d place;
        place[a] = at;
        place[b] = line;
        if (!dice.chance(0.4) || !near.isFree(index, place, kHalf_m + 1)) continue;
        PlantPlan hedge;
        hedge.kind = Greenery::kHedge;
        hedge.place = place;
        hedge.size_m = {kHalf_m, dice.uniform(0.35, 0.6), dice.uniform(0.5, 0.9)};
        hedge.turn = along_x ? 0 : M_PI / 2;
        hedge.seed = dice.bits();
        plan.plants.push_back(hedge);
      }
    }
  }
}

void parkAlongRoads(double reach, RandomStream& dice, TownPlan& plan) {
  constexpr double kFromMiddle_m = 2.2, kCrossing_m = 9;
  for (const bool along_x : {true, false}) {
    const auto& crossings = along_x ? plan.lines_x : plan.lines_y;
    for (const double line : along_x ? plan.lines_y : plan.lines_x) {
      for (double at = -reach; at < reach; at += dice.uniform(6, 45)) {
        const bool near_crossing = std::any_of(crossings.begin(), crossings.end(), [&](double c) {
          return std::abs(c - at) < kCrossing_m;
        });
        if (near_crossing) continue;
        const double side = line + (dice.chance(0.5) ? kFromMiddle_m : -kFromMiddle_m);
        plan.cars.push_back({along_x ? Eigen::Vector2d(at, side) : Eigen::Vector2d(side, at),
                             (along_x ? 0.0 : M_PI / 2) + (dice.chance(0.5) ? M_PI : 0.0),
                             dice.bits()});
      }
    }
  }
}

}  // namespace

void plantTown(const SceneOptions& options, std::uint64_t seed, TownPlan& plan) {
  RandomStream dice(seed * 2 + 2);
  const Neighbourhood near(plan);
  for (std::size_t i = 0; i < plan.blocks.size(); ++i) {
    const Block& block = plan.blocks[i];
    if (block.use == LandUse::kCrop || block.use == LandUse::kBlank) continue;
    const double hectares = block.box.volume() / 1e4;
    const double density = options.tree_density * (block.use == LandUse::kPark       ? 2.2
                                                   : block.use == LandUse::kBusiness ? 0.3
                                                                                     : 1.2);
    addTrees(block, i, density * hectares, near, dice, plan);
    if (block.use == LandUse::kHomes && options.tree_density > 0) {
      addHedges(block, i, near, dice, plan);
    }
  }
  if (plan.roads && options.building_density > 0) {
    parkAlongRoads(plan.lines_x.back(), dice, plan);
  }
}

}  // namespace cf
