// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "buildings.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "random_stream.h"

namespace cf {
namespace {

using Eigen::Vector3d;

/// Puts flat polygons into the mesh. Its own axes: x along the ridge, y across, z up.
class Mason {
 public:
  Mason(const Eigen::Vector2d& middle, double angle, Solids& solids)
      : middle_(middle), turn_(angle), solids_(solids) {}

  /// A convex polygon; u along its first edge, v at right angles to it, in its plane.
  void add(const std::vector<Vector3d>& polygon, Finish finish, const Tint& tint,
           std::uint32_t seed) {
    std::vector<Vector3d> p;
    for (const auto& q : polygon) {
      const Eigen::Vector2d flat = middle_ + turn_ * Eigen::Vector2d(q.x(), q.y());
      p.emplace_back(flat.x(), flat.y(), q.z());
    }
    const Vector3d u = (p[1] - p[0]).normalized();
    const Vector3d normal = u.cross(p[2] - p[0]).normalized();
    Part part;
    part.finish = finish;
    part.origin = p[0].cast<float>();
    part.u = u.cast<float>();
    part.v = normal.cross(u).cast<float>();
    part.tint = tint;
    part.width = static_cast<float>((p[1] - p[0]).norm());
    part.height = static_cast<float>((p[2] - p[0]).dot(normal.cross(u)));
    part.seed = seed;
    const auto first = static_cast<std::uint32_t>(solids_.vertices.size());
    for (const auto& q : p) solids_.vertices.push_back(q.cast<float>());
    for (std::uint32_t k = 2; k < p.size(); ++k) {
      solids_.corners.insert(solids_.corners.end(), {first, first + k - 1, first + k});
      solids_.part_of.push_back(static_cast<std::uint32_t>(solids_.parts.size()));
    }
    solids_.parts.push_back(part);
  }

  /// Four walls and a lid.
  void box(const Vector3d& low, const Vector3d& high, Finish walls, const Tint& wall_tint,
           Finish lid, const Tint& lid_tint, std::uint32_t seed) {
    for (int side = 0; side < 4; ++side) {
      const auto [a, b] = edge(low, high, side);
      add({{a.x(), a.y(), low.z()},
           {b.x(), b.y(), low.z()},
           {b.x(), b.y(), high.z()},
           {a.x(), a.y(), high.z()}},
          walls, wall_tint, seed + static_cast<std::uint32_t>(side));
    }
    add({{low.x(), low.y(), high.z()},
         {high.x(), low.y(), high.z()},
         high,
         {low.x(), high.y(), high.z()}},
        lid, lid_tint, seed + 4);
  }

  static std::pair<Eigen::Vector2d, Eigen::Vector2d> edge(const Vector3d& low, const Vector3d& high,
                                                          int side) {
    const Eigen::Vector2d c[4] = {
        {low.x(), low.y()}, {high.x(), low.y()}, {high.x(), high.y()}, {low.x(), high.y()}};
    return {c[side], c[(side + 1) % 4]};
  }

 private:
  Eigen::Vector2d middle_;
  Eigen::Rotation2Dd turn_;
  Solids& solids_;
};

const std::vector<Tint> kRoofTints = {{.07F, .10F, .26F}, {.09F, .13F, .30F},  {.06F, .08F, .18F},
                                      {.07F, .09F, .13F}, {.06F, .06F, .065F}, {.13F, .13F, .14F},
                                      {.10F, .16F, .34F}};
const std::vector<Tint> kWallTints = {
    {.58F, .62F, .64F}, {.42F, .55F, .6F}, {.35F, .45F, .55F}, {.14F, .2F, .36F}, {.5F, .5F, .5F}};
const std::vector<Tint> kDeckTints = {
    {.26F, .28F, .3F}, {.42F, .43F, .44F}, {.10F, .105F, .11F}, {.2F, .22F, .25F}};
const std::vector<Tint> kCarTints = {{.6F, .6F, .6F},    {.03F, .03F, .03F}, {.12F, .12F, .12F},
                                     {.05F, .05F, .35F}, {.3F, .12F, .05F},  {.3F, .3F, .31F},
                                     {.1F, .2F, .12F}};
const Tint kDark = {.05F, .05F, .05F}, kGlassTint = {.10F, .085F, .075F}, kPale = {.5F, .5F, .5F};
const Tint kChimney = {.10F, .13F, .25F}, kPanel = {.075F, .04F, .03F};

const Tint& pick(const std::vector<Tint>& tints, RandomStream& dice) {
  return tints[static_cast<std::size_t>(dice.below(static_cast<int>(tints.size())))];
}

/// A sloping roof over walls of half size (lx, ly), ridge along x.
struct SlopingRoof {
  double lx, ly, eaves_z, pitch, overhang;
  double ridge_z() const { return eaves_z + pitch * ly; }
  double edge_z() const { return eaves_z - pitch * overhang; }
  double height(double y) const { return ridge_z() - pitch * std::abs(y); }
};

/// Chimney, roof windows and solar panels.
void furnishRoof(const SlopingRoof& r, double usable_x, RandomStream& dice, Mason& mason) {
  if (dice.chance(0.7)) {
    const double x = dice.uniform(-0.7, 0.7) * usable_x, y = dice.uniform(-0.3, 0.3) * r.ly;
    mason.box({x - 0.35, y - 0.3, r.height(r.ly * 0.5)}, {x + 0.35, y + 0.3, r.ridge_z() + 0.7},
              Finish::kBrick, kChimney, Finish::kPlain, kDark, dice.bits());
  }
  const double slope = std::hypot(1, r.pitch);
  auto panel = [&](double x0, double x1, double y0, double y1, double side, Finish finish,
                   const Tint& tint) {
    constexpr double kLift_m = 0.09;
    auto at = [&](double x, double y) {
      return Vector3d(x, side * y, r.height(y) + kLift_m * slope);
    };
    std::vector<Vector3d> p = {at(x0, y1), at(x1, y1), at(x1, y0), at(x0, y0)};
    if (side > 0) p = {at(x1, y1), at(x0, y1), at(x0, y0), at(x1, y0)};
    mason.add(p, finish, tint, dice.bits());
  };
  for (const double side : {-1.0, 1.0}) {
    if (dice.chance(0.18) && usable_x > 2.5) {
      const double x = usable_x * dice.uniform(0.5, 0.85);
      panel(-x, x, 0.2 * r.ly, dice.uniform(0.6, 0.85) * r.ly, side, Finish::kSolar, kPanel);
      continue;
    }
    for (int k = dice.below(4); k > 0; --k) {
      const double x = dice.uniform(-0.8, 0.8) * usable_x, y = dice.uniform(0.3, 0.7) * r.ly;
      panel(x - 0.45, x + 0.45, y - 0.5, y + 0.5, side, Finish::kGlass, kGlassTint);
    }
  }
}

void addSlopingRoof(const BuildingPlan& plan, const SlopingRoof& r, const Tint& tint,
                    const Tint& wall, RandomStream& dice, Mason& mason) {
  const double x = r.lx + r.overhang, y = r.ly + r.overhang;
  const bool hip = plan.roof == Roof::kHip && r.lx > r.ly * 0.9;
  const double ridge = hip ? std::max(0.05, x - y) : x;
  const double top = r.ridge_z(), low = r.edge_z();
  const std::uint32_t seed = dice.bits();
  mason.add({{-x, -y, low}, {x, -y, low}, {ridge, 0, top}, {-ridge, 0, top}}, Finish::kTiledRoof,
            tint, seed);
  mason.add({{x, y, low}, {-x, y, low}, {-ridge, 0, top}, {ridge, 0, top}}, Finish::kTiledRoof,
            tint, seed + 1);
  if (hip) {
    mason.add({{x, -y, low}, {x, y, low}, {ridge, 0, top}}, Finish::kTiledRoof, tint, seed + 2);
    mason.add({{-x, y, low}, {-x, -y, low}, {-ridge, 0, top}}, Finish::kTiledRoof, tint, seed + 3);
  } else {
    for (const double s : {-1.0, 1.0}) {
      mason.add(
          {{s * r.lx, -s * r.ly, r.eaves_z}, {s * r.lx, s * r.ly, r.eaves_z}, {s * r.lx, 0, top}},
          Finish::kPlain, wall, seed + 4);
    }
  }
  // Gutters along the eaves, and a ridge of capping tiles.
  for (const double s : {-1.0, 1.0}) {
    mason.box({-x, s * (y + 0.06) - 0.06, low - 0.1}, {x, s * (y + 0.06) + 0.06, low},
              Finish::kPlain, kPale, Finish::kPlain, 0.6F * kPale, seed + 6);
  }
  mason.box({-ridge, -0.12, top - 0.1}, {ridge, 0.12, top + 0.06}, Finish::kPlain, 0.8F * tint,
            Finish::kPlain, 1.15F * tint, seed + 7);
  furnishRoof(r, hip ? ridge : r.lx * 0.9, dice, mason);
}

void addFlatRoof(const Vector3d& half, double top, const Tint& wall, RandomStream& dice,
                 Mason& mason) {
  const Tint deck = pick(kDeckTints, dice);
  mason.add({{-half.x(), -half.y(), top},
             {half.x(), -half.y(), top},
             {half.x(), half.y(), top},
             {-half.x(), half.y(), top}},
            Finish::kFlatRoof, deck, dice.bits());
  // The parapet: four low walls that reach a little over the facade.
  constexpr double kThick_m = 0.3;
  const double rim = top + dice.uniform(0.25, 0.6), x = half.x() + 0.08, y = half.y() + 0.08;
  const std::uint32_t seed = dice.bits();
  auto wallBox = [&](double x0, double y0, double x1, double y1) {
    mason.box({x0, y0, top - 0.3}, {x1, y1, rim}, Finish::kPlain, 0.9F * wall, Finish::kPlain,
              kPale, seed);
  };
  wallBox(-x, -y, x, -y + kThick_m);
  wallBox(-x, y - kThick_m, x, y);
  wallBox(-x, -y + kThick_m, -x + kThick_m, y - kThick_m);
  wallBox(x - kThick_m, -y + kThick_m, x, y - kThick_m);
  const int boxes = static_cast<int>(std::clamp(half.x() * half.y() / 18, 1.0, 14.0));
  for (int k = 0; k < boxes; ++k) {
    const double bx = dice.uniform(0.4, 1.3), by = dice.uniform(0.4, 1.0);
    const double cx = dice.uniform(-1, 1) * std::max(0.1, half.x() - 2);
    const double cy = dice.uniform(-1, 1) * std::max(0.1, half.y() - 2);
    const Tint tint = dice.chance(0.4) ? kGlassTint : kPale;
    mason.box({cx - bx, cy - by, top}, {cx + bx, cy + by, top + dice.uniform(0.2, 1.6)},
              Finish::kPlain, 0.7F * kPale, Finish::kPlain, tint, dice.bits());
  }
}

}  // namespace

void addBuilding(const BuildingPlan& plan, const Eigen::Rotation2Dd& turn, const Terrain& terrain,
                 Solids& solids) {
  RandomStream dice(plan.seed);
  const Eigen::Vector2d half = plan.box.sizes() / 2;
  double ground = -1e9, foot = 1e9;
  for (int k = 0; k < 4; ++k) {
    const Eigen::Vector2d corner =
        turn * plan.box.corner(static_cast<Eigen::AlignedBox2d::CornerType>(k));
    const double z = terrain.height(corner.x(), corner.y());
    ground = std::max(ground, z);
    foot = std::min(foot, z);
  }
  const double angle = turn.angle() + (plan.ridge_along_x ? 0 : M_PI / 2);
  Mason mason(turn * plan.box.center(), angle, solids);
  const double lx = plan.ridge_along_x ? half.x() : half.y();
  const double ly = plan.ridge_along_x ? half.y() : half.x();
  const double eaves = ground + plan.eaves_m;
  const Tint wall = pick(kWallTints, dice), roof = pick(kRoofTints, dice);
  const std::uint32_t seed = dice.bits();
  const Vector3d low(-lx, -ly, foot - 1), high(lx, ly, eaves);
  for (int side = 0; side < 4; ++side) {
    const auto [a, b] = Mason::edge(low, high, side);
    // Texture rows are counted from the eaves down, whatever the slope of the ground.
    mason.add({{b.x(), b.y(), eaves},
               {a.x(), a.y(), eaves},
               {a.x(), a.y(), low.z()},
               {b.x(), b.y(), low.z()}},
              Finish::kWall, wall, seed);
  }
  if (plan.roof == Roof::kFlat) {
    addFlatRoof({lx, ly, 0}, eaves, wall, dice, mason);
    return;
  }
  const double tint_change = dice.uniform(0.8, 1.2);
  const SlopingRoof sloping = {lx, ly, eaves, plan.pitch, plan.home ? 0.45 : 0.3};
  addSlopingRoof(plan, sloping, static_cast<float>(tint_change) * roof, wall, dice, mason);
}

void addCar(const CarPlan& plan, const Eigen::Rotation2Dd& turn, const Terrain& terrain,
            Solids& solids) {
  RandomStream dice(plan.seed);
  const Eigen::Vector2d middle = turn * plan.place;
  const double ground = terrain.height(middle.x(), middle.y());
  Mason mason(middle, turn.angle() + plan.turn + dice.uniform(-0.03, 0.03), solids);
  const Tint tint = pick(kCarTints, dice);
  const double x = dice.uniform(1.95, 2.3), y = dice.uniform(0.82, 0.92);
  const double belt = ground + 0.88, top = ground + dice.uniform(1.4, 1.6);
  mason.box({-x, -y, ground + 0.1}, {x, y, belt}, Finish::kPlain, 0.8F * tint, Finish::kPlain, tint,
            dice.bits());
  // The cabin narrows towards its roof: glass all round.
  const double rear = -0.85 * x, front = 0.35 * x, dx = 0.5, dy = 0.14;
  const std::vector<Vector3d> below = {
      {rear, -y, belt}, {front, -y, belt}, {front, y, belt}, {rear, y, belt}};
  const std::vector<Vector3d> above = {{rear + 0.6 * dx, -y + dy, top},
                                       {front - dx, -y + dy, top},
                                       {front - dx, y - dy, top},
                                       {rear + 0.6 * dx, y - dy, top}};
  for (std::size_t k = 0; k < 4; ++k) {
    const std::size_t m = (k + 1) % 4;
    mason.add({below[k], below[m], above[m], above[k]}, Finish::kPlain, 0.5F * kGlassTint,
              dice.bits());
  }
  mason.add(above, Finish::kPlain, tint, dice.bits());
}

}  // namespace cf
