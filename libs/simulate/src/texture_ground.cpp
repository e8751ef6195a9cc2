// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "texture_ground.h"

#include <algorithm>
#include <cmath>

#include "texture_patterns.h"

namespace cf {
namespace {

constexpr float kCell_m = 4;  // of the grid that finds decals

const Tint kLawn = {.045F, .15F, .085F}, kMeadow = {.055F, .15F, .12F}, kDry = {.08F, .19F, .2F};
const Tint kSoil = {.09F, .145F, .2F}, kAsphalt = {.135F, .135F, .135F};
const Tint kPavement = {.27F, .28F, .29F}, kKerb = {.4F, .41F, .42F}, kWhite = {.7F, .72F, .74F};
const Tint kGravel = {.25F, .32F, .37F}, kWater = {.07F, .065F, .04F},
           kCropTint = {.03F, .16F, .08F};
const Tint kPoolBlue = {.45F, .38F, .12F}, kFlowers = {.08F, .09F, .2F};
const std::vector<Tint> kPavings = {
    {.27F, .28F, .29F}, {.22F, .3F, .36F}, {.15F, .19F, .29F}, {.17F, .17F, .175F}};

float randomOf(std::uint32_t seed, std::uint32_t what) { return unit(hash2(seed, what)); }

}  // namespace

GroundPaint::Lines::Lines(const std::vector<double>& lines) {
  for (const double line : lines) at.push_back(static_cast<float>(line));
  first = at.front();
  std::uint32_t index = 0;
  for (float m = first; m < at.back(); m += 1) {
    while (index + 2 < at.size() && at[index + 1] <= m) ++index;
    bins.push_back(index);
  }
}

std::size_t GroundPaint::Lines::below(float coordinate) const {
  const int bin = std::clamp(floorInt(coordinate - first), 0, static_cast<int>(bins.size()) - 1);
  std::size_t index = bins[static_cast<std::size_t>(bin)];
  while (index + 2 < at.size() && at[index + 1] <= coordinate) ++index;
  return index;
}

GroundPaint::GroundPaint(const TownPlan& plan)
    : plan_(plan),
      cos_(static_cast<float>(std::cos(plan.angle))),
      sin_(static_cast<float>(std::sin(plan.angle))),
      x_(plan.lines_x),
      y_(plan.lines_y),
      corner_x_(x_.first),
      corner_y_(y_.first),
      cells_across_(floorInt((x_.at.back() - corner_x_) / kCell_m) + 1),
      cells_up_(floorInt((y_.at.back() - corner_y_) / kCell_m) + 1) {
  std::vector<std::vector<std::uint32_t>> lists(static_cast<std::size_t>(cells_across_) *
                                                static_cast<std::size_t>(cells_up_));
  constexpr double kMargin_m = 0.5;  // for the footprint
  for (std::uint32_t d = 0; d < plan.decals.size(); ++d) {
    const auto& box = plan.decals[d].box;
    auto cell = [](double v, double corner, int most) {
      return std::clamp(static_cast<int>(std::floor((v - corner) / kCell_m)), 0, most - 1);
    };
    const int c0 = cell(box.min().x() - kMargin_m, corner_x_, cells_across_);
    const int c1 = cell(box.max().x() + kMargin_m, corner_x_, cells_across_);
    const int r0 = cell(box.min().y() - kMargin_m, corner_y_, cells_up_);
    const int r1 = cell(box.max().y() + kMargin_m, corner_y_, cells_up_);
    for (int r = r0; r <= r1; ++r) {
      for (int c = c0; c <= c1; ++c)
        lists[static_cast<std::size_t>(r * cells_across_ + c)].push_back(d);
    }
  }
  cell_start_.push_back(0);
  for (const auto& list : lists) {
    cell_decals_.insert(cell_decals_.end(), list.begin(), list.end());
    cell_start_.push_back(static_cast<std::uint32_t>(cell_decals_.size()));
  }
}

void GroundPaint::paint(std::size_t sample, float x, float y, float footprint,
                        Fragments& out) const {
  const Place p = {sample, cos_ * x + sin_ * y, cos_ * y - sin_ * x, footprint};
  const float left = paintDecals(p, out);
  if (left <= 0) return;
  const std::size_t i = x_.below(p.u), j = y_.below(p.v);
  const Block& block = plan_.blocks[i * static_cast<std::size_t>(plan_.blocksAcross()) + j];
  if (!plan_.roads) {
    paintBlock(p, block, left, out);
    return;
  }
  auto offset = [](float at, float low, float high) {
    return at - low < high - at ? at - low : at - high;
  };
  const float off_x = offset(p.u, x_.at[i], x_.at[i + 1]);
  const float off_y = offset(p.v, y_.at[j], y_.at[j + 1]);
  const float distance = std::min(std::abs(off_x), std::abs(off_y));
  const auto half_road = static_cast<float>(plan_.half_road_m);
  const auto kerb = static_cast<float>(plan_.kerb_m);
  constexpr float kKerb_m = 0.18F;
  const float road = inside(distance, -half_road, half_road, footprint);
  const float stone = inside(distance, half_road, half_road + kKerb_m, footprint);
  const float walk = inside(distance, half_road + kKerb_m, kerb, footprint);
  if (road > 0) paintRoad(p, off_x, off_y, left * road, out);
  out.add(Material::kConcrete, sample, p.u, p.v, footprint, left * stone, kKerb);
  if (walk > 0) {
    constexpr float kSlab_m = 0.6F, kJoint_m = 0.02F;
    const float joints =
        bars(p.u, kSlab_m, kJoint_m, footprint) + bars(p.v, kSlab_m, kJoint_m, footprint);
    const float slab = 1 + 0.1F * cellNoise(p.u, p.v, kSlab_m, kSlab_m, footprint, 7);
    out.add(Material::kConcrete, sample, p.u, p.v, footprint, left * walk,
            slab * (1 - 0.5F * joints) * kPavement);
  }
  const float rest = 1 - road - stone - walk;
  if (rest > 1e-4F) paintBlock(p, block, left * rest, out);
}

void GroundPaint::paintRoad(const Place& p, float off_x, float off_y, float share,
                            Fragments& out) const {
  // Along x where the road's middle is nearer in y.
  const bool along_x = std::abs(off_y) < std::abs(off_x);
  const float across = along_x ? off_y : off_x, along = along_x ? p.u : p.v;
  const float to_crossing = std::abs(along_x ? off_x : off_y);
  const auto half = static_cast<float>(plan_.half_road_m);
  const float fp = p.footprint;
  float white = 0;
  if (to_crossing > half + 4) {
    white = inside(across, -0.07F, 0.07F, fp) * bars(along, 6, 3, fp) +
            inside(std::abs(across), half - 0.3F, half - 0.2F, fp);
  } else {
    white = inside(to_crossing, half + 0.8F, half + 3.3F, fp) * bars(across, 1, 0.5F, fp);
  }
  // Lighter where the wheels run.
  const float wheel = std::abs(std::abs(across) - 1.5F) - 0.8F;
  const float worn = 1 + 0.08F * std::clamp(-wheel / 0.4F, -1.0F, 1.0F);
  out.add(Material::kAsphalt, p.sample, p.u, p.v, fp, share,
          mix(worn * kAsphalt, kWhite, 0.8F * std::min(white, 1.0F)));
}

void GroundPaint::paintBlock(const Place& p, const Block& block, float share,
                             Fragments& out) const {
  const float fp = p.footprint;
  switch (block.use) {
    case LandUse::kBlank:
      out.add(Material::kSmooth, p.sample, p.u, p.v, fp, share, kWater);
      return;
    case LandUse::kCrop: {
      const float period = 0.7F + 0.9F * randomOf(block.seed, 1);
      const float green =
          bars(randomOf(block.seed, 2) < 0.5F ? p.u : p.v, period, 0.55F * period, fp);
      out.add(Material::kLawn, p.sample, p.u, p.v, fp, share * green,
              mix(kCropTint, kDry, 0.5F * randomOf(block.seed, 3)));
      out.add(Material::kSoil, p.sample, p.u, p.v, fp, share * (1 - green), kSoil);
      return;
    }
    case LandUse::kPark: {
      const float reach = 12 + 8 * randomOf(block.seed, 4);
      const float bend = std::fabs(p.u / reach - std::floor(p.u / reach) - 0.5F) * 4 - 1;
      const auto middle = static_cast<float>(block.box.center().y());
      const float off = p.v - middle - 3 * bend * (1.5F - 0.5F * bend * bend);
      const float path = inside(off, -0.9F, 0.9F, fp);
      out.add(Material::kGravel, p.sample, p.u, p.v, fp, share * path, kGravel);
      const bool wild = randomOf(block.seed, 5) < 0.6F;
      out.add(wild ? Material::kMeadow : Material::kLawn, p.sample, p.u, p.v, fp,
              share * (1 - path), mix(kMeadow, kDry, 0.7F * randomOf(block.seed, 6)));
      return;
    }
    case LandUse::kHomes:
    case LandUse::kBusiness: {
      // Every garden is mown and watered in its own way.
      const auto column = static_cast<std::uint32_t>(
          floorInt((p.u - static_cast<float>(block.box.min().x())) / 15.5F));
      const auto row = static_cast<std::uint32_t>(
          floorInt((p.v - static_cast<float>(block.box.min().y())) / 18));
      const std::uint32_t garden = hash2(block.seed + column, row);
      const bool wild = randomOf(garden, 1) < 0.3F;
      const Tint tint = mix(kLawn, kDry, 0.65F * randomOf(garden, 2));
      out.add(wild ? Material::kMeadow : Material::kLawn, p.sample, p.u, p.v, fp, share,
              (0.85F + 0.3F * randomOf(garden, 3)) * tint);
      return;
    }
  }
}

float GroundPaint::paintDecals(const Place& p, Fragments& out) const {
  const int column = std::clamp(floorInt((p.u - corner_x_) / kCell_m), 0, cells_across_ - 1);
  const int row = std::clamp(floorInt((p.v - corner_y_) / kCell_m), 0, cells_up_ - 1);
  const auto cell = static_cast<std::size_t>(row * cells_across_ + column);
  float left = 1;
  for (std::uint32_t k = cell_start_[cell + 1]; k > cell_start_[cell] && left > 0; --k) {
    const Decal& decal = plan_.decals[cell_decals_[k - 1]];
    const Eigen::Vector2f low = decal.box.min().cast<float>(), high = decal.box.max().cast<float>();
    const float covered =
        inside(p.u, low.x(), high.x(), p.footprint) * inside(p.v, low.y(), high.y(), p.footprint);
    if (covered <= 0) continue;
    paintDecal(p, decal, left * covered, out);
    left -= left * covered;
  }
  return left;
}

void GroundPaint::paintDecal(const Place& p, const Decal& decal, float share,
                             Fragments& out) const {
  const float fp = p.footprint;
  const auto low = decal.box.min().cast<float>().eval();
  auto add = [&](Material material, const Tint& tint) {
    out.add(material, p.sample, p.u, p.v, fp, share, tint);
  };
  switch (decal.paint) {
    case Paint::kPaving: {
      const float slab = 0.2F + 0.4F * randomOf(decal.seed, 1);
      const float joints =
          bars(p.u - low.x(), slab, 0.02F, fp) + bars(p.v - low.y(), slab, 0.02F, fp);
      const float own =
          1 + 0.14F * cellNoise(p.u - low.x(), p.v - low.y(), slab, slab, fp, decal.seed);
      add(Material::kConcrete,
          own * (1 - 0.45F * joints) * kPavings[hash2(decal.seed, 2) % kPavings.size()]);
      return;
    }
    case Paint::kGravel:
      add(Material::kGravel, kGravel);
      return;
    case Paint::kSoil:
      add(Material::kSoil, kSoil);
      return;
    case Paint::kBed: {
      const float flower = std::max(0.0F, cellNoise(p.u, p.v, 0.15F, 0.15F, fp, decal.seed));
      add(Material::kFoliage, mix(kMeadow, kFlowers, flower));
      return;
    }
    case Paint::kParking: {
      const float along = p.v - low.y(), in_row = along - 8 * std::floor(along / 8);
      const float white = bars(p.u - low.x() - 1.94F, 2.5F, 0.12F, fp) * inside(in_row, 0, 5, fp);
      add(Material::kAsphalt, mix(1.15F * kAsphalt, kWhite, 0.7F * white));
      return;
    }
    case Paint::kPatch:
      add(Material::kAsphalt, (0.55F + 0.35F * randomOf(decal.seed, 1)) * kAsphalt);
      return;
    case Paint::kPool: {
      const auto high = decal.box.max().cast<float>().eval();
      const float water = inside(p.u, low.x() + 0.3F, high.x() - 0.3F, fp) *
                          inside(p.v, low.y() + 0.3F, high.y() - 0.3F, fp);
      add(Material::kPlaster, mix(kWhite, kPoolBlue, water));
      return;
    }
  }
}

}  // namespace cf
