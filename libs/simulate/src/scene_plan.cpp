// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "scene_plan.h"

#include <algorithm>
#include <cmath>

#include "random_stream.h"

namespace cf {
namespace {

constexpr double kFieldWidth_m = 80;  // of a block where there are no roads

std::vector<double> roadLines(double reach, double spacing, RandomStream& dice) {
  std::vector<double> lines;
  double at = -reach - spacing * dice.uniform();
  while (lines.size() < 2 || lines.back() < reach) {
    lines.push_back(at);
    at += spacing * dice.uniform(0.75, 1.3);
  }
  return lines;
}

bool isFree(const std::vector<BuildingPlan>& buildings, std::size_t first,
            const Eigen::AlignedBox2d& box, double gap) {
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(gap);
  const Eigen::AlignedBox2d wide(box.min() - margin, box.max() + margin);
  return std::none_of(buildings.begin() + static_cast<std::ptrdiff_t>(first), buildings.end(),
                      [&](const BuildingPlan& b) { return b.box.intersects(wide); });
}

Eigen::AlignedBox2d rectangle(double x0, double y0, double x1, double y1) {
  return {Eigen::Vector2d(std::min(x0, x1), std::min(y0, y1)),
          Eigen::Vector2d(std::max(x0, x1), std::max(y0, y1))};
}

/// A home facing one side of its block, with its drive, terrace, garden beds.
void addGarden(const Block& block, const BuildingPlan& home, int side, RandomStream& dice,
               TownPlan& plan) {
  const bool along_x = side < 2;  // the street runs along x
  const int a = along_x ? 0 : 1, b = 1 - a;
  const bool low = side % 2 == 0;
  const double street = low ? block.box.min()[b] : block.box.max()[b];
  const double front = low ? home.box.min()[b] : home.box.max()[b];
  const double back = low ? home.box.max()[b] : home.box.min()[b];
  const double into = low ? 1 : -1;
  auto add = [&](double a0, double b0, double a1, double b1, Paint paint) {
    Eigen::AlignedBox2d box = along_x ? rectangle(a0, b0, a1, b1) : rectangle(b0, a0, b1, a1);
    box.clamp(block.box);
    if (!box.isEmpty()) plan.decals.push_back({box, paint, dice.bits()});
  };
  const double left = home.box.min()[a], right = home.box.max()[a];
  const double drive = dice.chance(0.5) ? left + dice.uniform(0.2, 1) : right - dice.uniform(3, 4);
  add(drive, street, drive + 2.8, front, dice.chance(0.3) ? Paint::kGravel : Paint::kPaving);
  if (dice.chance(0.7)) {
    add(left + dice.uniform(0, 3), back, right - dice.uniform(0, 3),
        back + into * dice.uniform(2, 4.5), Paint::kPaving);
  }
  if (dice.chance(0.45)) {
    const double at = dice.uniform(left - 2, right - 2), from = back + into * dice.uniform(5, 8);
    add(at, from, at + dice.uniform(2, 5), from + into * dice.uniform(1.2, 3),
        dice.chance(0.5) ? Paint::kSoil : Paint::kBed);
  }
  if (dice.chance(0.12)) {
    const double at = dice.uniform(left, right - 3), from = back + into * dice.uniform(5, 6);
    add(at, from, at + dice.uniform(3.5, 6), from + into * 3, Paint::kPool);
  }
  if (dice.chance(0.5)) {
    const Eigen::Vector2d spot = along_x ? Eigen::Vector2d(drive + 1.4, (street + front) / 2)
                                         : Eigen::Vector2d((street + front) / 2, drive + 1.4);
    if (std::abs(front - street) > 4.8) {
      plan.cars.push_back({spot, along_x ? M_PI / 2 : 0.0, dice.bits()});
    }
  }
}

void addHomes(const Block& block, double wanted, RandomStream& dice, TownPlan& plan) {
  const std::size_t first = plan.buildings.size();
  const int count = static_cast<int>(wanted) + (dice.chance(wanted - std::floor(wanted)) ? 1 : 0);
  constexpr int kTries = 60;
  for (int k = 0, tries = 0; k < count && tries < kTries * count; ++tries) {
    const int side = dice.below(4);
    const bool along_x = side < 2;
    const int a = along_x ? 0 : 1, b = 1 - a;
    const double setback = dice.uniform(2.5, 6.5);
    double width = dice.uniform(8, 13), depth = dice.uniform(7, 10);
    if (tries > kTries * count / 2) width *= 0.8, depth *= 0.85;  // it is getting tight
    Eigen::Vector2d low, high;
    const double room = block.box.sizes()[a] - width - 4;
    if (room < 0 || block.box.sizes()[b] < depth + 2 * setback) continue;
    low[a] = block.box.min()[a] + 2 + dice.uniform(0, room);
    high[a] = low[a] + width;
    low[b] = side % 2 == 0 ? block.box.min()[b] + setback : block.box.max()[b] - setback - depth;
    high[b] = low[b] + depth;
    const Eigen::AlignedBox2d box(low, high);
    if (!isFree(plan.buildings, first, box, 2.2)) continue;
    BuildingPlan home;
    home.box = box;
    home.ridge_along_x = along_x == (width > depth || dice.chance(0.5));
    home.eaves_m = dice.chance(0.45) ? dice.uniform(2.8, 3.6) : dice.uniform(5.2, 6.4);
    home.pitch = dice.uniform(0.45, 0.95);
    const double kind = dice.uniform();
    home.roof = kind < 0.5 ? Roof::kGable : (kind < 0.82 ? Roof::kHip : Roof::kFlat);
    home.seed = dice.bits();
    plan.buildings.push_back(home);
    addGarden(block, home, side, dice, plan);
    ++k;
  }
}

/// Halls with flat roofs and a car park.
void addBusiness(const Block& block, RandomStream& dice, TownPlan& plan) {
  const std::size_t first = plan.buildings.size();
  const Eigen::Vector2d size = block.box.sizes();
  const int halls = 1 + dice.below(3);
  for (int k = 0, tries = 0; k < halls && tries < 40; ++tries) {
    const Eigen::Vector2d half(dice.uniform(0.12, 0.26) * size.x(),
                               dice.uniform(0.12, 0.26) * size.y());
    const Eigen::Vector2d room = size / 2 - half - Eigen::Vector2d::Constant(4);
    if (room.minCoeff() <= 0) continue;
    const Eigen::Vector2d middle =
        block.box.center() +
        Eigen::Vector2d(dice.uniform(-1, 1) * room.x(), dice.uniform(-1, 1) * room.y());
    const Eigen::AlignedBox2d box(middle - half, middle + half);
    if (!isFree(plan.buildings, first, box, 7)) continue;
    BuildingPlan hall;
    hall.box = box;
    hall.ridge_along_x = half.x() > half.y();
    hall.eaves_m = dice.uniform(5, 15);
    hall.roof = dice.chance(0.75) ? Roof::kFlat : Roof::kGable;
    hall.pitch = 0.2;
    hall.home = false;
    hall.seed = dice.bits();
    plan.buildings.push_back(hall);
    ++k;
  }
  const Eigen::Vector2d margin(2, 2);
  plan.decals.push_back(
      {{block.box.min() + margin, block.box.max() - margin}, Paint::kParking, dice.bits()});
  constexpr double kBay_m = 2.5, kAisle_m = 16;
  for (double y = block.box.min().y() + 4.5; y < block.box.max().y() - 4; y += kAisle_m / 2) {
    for (double x = block.box.min().x() + 4; x < block.box.max().x() - 4; x += kBay_m) {
      const Eigen::Vector2d at(x + kBay_m / 2, y);
      const Eigen::AlignedBox2d box(at - Eigen::Vector2d(1.2, 2.6), at + Eigen::Vector2d(1.2, 2.6));
      if (dice.chance(0.3) && isFree(plan.buildings, first, box, 0.5)) {
        plan.cars.push_back({at, M_PI / 2, dice.bits()});
      }
    }
  }
}

void patchRoads(double reach, RandomStream& dice, TownPlan& plan) {
  for (const bool along_x : {true, false}) {
    for (const double line : along_x ? plan.lines_y : plan.lines_x) {
      for (double at = -reach; at < reach; at += dice.uniform(6, 40)) {
        const double length = dice.uniform(0.5, 6), side = dice.uniform(-2.6, 1);
        const double width = dice.uniform(0.5, 1.6);
        const auto box = along_x ? rectangle(at, line + side, at + length, line + side + width)
                                 : rectangle(line + side, at, line + side + width, at + length);
        plan.decals.push_back({box, Paint::kPatch, dice.bits()});
      }
    }
  }
}

}  // namespace

TownPlan planTown(const SceneOptions& options, const Eigen::Vector2d& half_extent_m,
                  std::uint64_t seed) {
  RandomStream dice(seed * 2 + 1);
  TownPlan plan;
  plan.angle = dice.uniform(8, 35) * M_PI / 180;
  plan.turn = Eigen::Rotation2Dd(plan.angle);
  plan.roads = options.road_spacing_m > 0;
  if (!plan.roads) plan.half_road_m = plan.kerb_m = 0;
  const double spacing = plan.roads ? std::max(20.0, options.road_spacing_m) : kFieldWidth_m;
  const double reach = half_extent_m.norm();
  plan.lines_x = roadLines(reach, spacing, dice);
  plan.lines_y = roadLines(reach, spacing, dice);
  const double built = std::max(0.0, 1 - options.crop_share - options.blank_share);
  const Eigen::Vector2d kerb = Eigen::Vector2d::Constant(plan.kerb_m);
  for (std::size_t i = 0; i + 1 < plan.lines_x.size(); ++i) {
    for (std::size_t j = 0; j + 1 < plan.lines_y.size(); ++j) {
      Block block;
      block.box = {Eigen::Vector2d(plan.lines_x[i], plan.lines_y[j]) + kerb,
                   Eigen::Vector2d(plan.lines_x[i + 1], plan.lines_y[j + 1]) - kerb};
      block.seed = dice.bits();
      const double draw = dice.uniform(), kind = dice.uniform();
      if (draw < options.blank_share) {
        block.use = LandUse::kBlank;
      } else if (draw < options.blank_share + options.crop_share) {
        block.use = LandUse::kCrop;
      } else if (options.building_density > 0 && kind < 0.85) {
        block.use = kind < 0.1 ? LandUse::kBusiness : LandUse::kHomes;
      }
      const double hectares = spacing * spacing / 1e4;
      // Parks and halls take 0.25 of the built blocks: the homes of the others make up for it.
      const double homes = options.building_density * hectares / std::max(0.1, built * 0.8);
      if (block.use == LandUse::kHomes) addHomes(block, std::min(homes, 40.0), dice, plan);
      if (block.use == LandUse::kBusiness) addBusiness(block, dice, plan);
      plan.blocks.push_back(block);
    }
  }
  if (plan.roads) patchRoads(reach, dice, plan);
  return plan;
}

}  // namespace cf
