// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/fuse/cleaning.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <random>

#include "cf/fuse/deliver_cloud.h"
#include "cf/fuse/voxel_tile_map.h"
#include "fuse/scratch_map.h"

namespace cf {
namespace {

using test::ScratchMap;

constexpr double kVoxel = 0.1;
constexpr int kTrusted = 3;

/// Builds a tile of voxels and remembers what each is. One point a cell, as a tile has.
class Scene {
 public:
  explicit Scene(unsigned seed) : random_(seed) {}

  void add(double x, double y, double z, int views, int kind) {
    TilePoint point;
    point.position_m = {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
    point.views = static_cast<std::uint16_t>(views);
    point.confidence = 1;
    point.bgr[0] = static_cast<std::uint8_t>(kind);
    tile_.points.push_back(point);
  }
  /// Horizontal patch; `share` of its voxels are there, heights scatter by one voxel.
  void plane(double x0, double y0, double x1, double y1, double z, int views, int kind,
             double share = 0.7) {
    std::normal_distribution<double> noise(0, kVoxel);
    for (double x = x0 + kVoxel / 2; x < x1; x += kVoxel)
      for (double y = y0 + kVoxel / 2; y < y1; y += kVoxel)
        if (uniform(0, 1) < share) add(x, y, z + noise(random_), views, kind);
  }
  double uniform(double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(random_);
  }
  std::size_t count(int kind) const { return count(tile_, kind); }
  static std::size_t count(const Tile& tile, int kind) {
    std::size_t n = 0;
    for (const TilePoint& point : tile.points) n += point.bgr[0] == kind;
    return n;
  }
  const Tile& tile() const { return tile_; }
  Tile clean() const { return cleaned(tile_, {}, kVoxel, kTrusted); }
  /// Share of what was added as `kind` that cleaning keeps.
  double kept(int kind) const {
    return static_cast<double>(count(clean(), kind)) / static_cast<double>(count(kind));
  }

 private:
  std::mt19937 random_;
  Tile tile_;
};

enum Kind { kGround, kFlying, kThin, kSinglePair };

TEST(Cleaning, RemovesScatteredOutliersAndKeepsThePlane) {
  for (const int ground_views : {1, 2, 6}) {
    Scene scene(1);
    scene.plane(0, 0, 40, 40, 0, ground_views, kGround);
    for (int i = 0; i < 3000; ++i) {
      const double height = scene.uniform(0.8, 15);
      scene.add(scene.uniform(0, 40), scene.uniform(0, 40), i % 2 ? height : -height, 1, kFlying);
    }
    EXPECT_GE(scene.kept(kGround), 0.995) << ground_views;
    EXPECT_LE(scene.kept(kFlying), 0.05) << ground_views;
  }
}

TEST(Cleaning, HoldsForVoxelsMuchSmallerThanTheSpacingOfThePoints) {
  Scene scene(2);
  scene.plane(0, 0, 60, 60, 0, 1, kGround, 0.08);
  for (int i = 0; i < 600; ++i)
    scene.add(scene.uniform(0, 60), scene.uniform(0, 60), scene.uniform(4, 20), 1, kFlying);
  EXPECT_GE(scene.kept(kGround), 0.995);
  EXPECT_LE(scene.kept(kFlying), 0.05);
}

TEST(Cleaning, RemovesBlobsAboveAndBelowAWellSeenSurface) {
  Scene scene(3);
  scene.plane(0, 0, 40, 40, 0, 5, kGround);
  for (int i = 0; i < 20; ++i) {
    const double x = scene.uniform(1, 38), y = scene.uniform(1, 38);
    scene.plane(x, y, x + 1.6, y + 1.6, i % 2 ? 3 + 0.5 * i : -3, 1, kFlying);
  }
  EXPECT_GE(scene.kept(kGround), 0.995);
  EXPECT_LE(scene.kept(kFlying), 0.05);
}

TEST(Cleaning, RemovesAWideSecondLayerThatFewFramesSaw) {
  Scene scene(8);
  scene.plane(0, 0, 40, 40, 0, 16, kGround);
  scene.plane(10, 10, 20, 20, 2, 2, kFlying);  // an eighth of the frames
  scene.plane(25, 25, 35, 35, 2, 3, kThin);    // trusted
  EXPECT_GE(scene.kept(kGround), 0.995);
  EXPECT_LE(scene.kept(kFlying), 0.01);
  EXPECT_GE(scene.kept(kThin), 0.99);
}

TEST(Cleaning, KeepsWhatManyDepthFramesSawEvenIfSmall) {
  Scene scene(4);
  scene.plane(0, 0, 40, 40, 0, 6, kGround);
  scene.plane(20, 20, 20.8, 20.8, 7, kTrusted, kThin);
  EXPECT_EQ(scene.kept(kThin), 1);
}

TEST(Cleaning, KeepsPolesAndRoofEdges) {
  Scene scene(5);
  scene.plane(0, 0, 40, 40, 0, 1, kGround, 0.95);
  for (double z = 0.25; z < 6; z += kVoxel) scene.add(5.05, 5.05, z, 1, kThin);
  scene.plane(20, 20, 30, 30, 6, 1, kThin, 0.95);  // a roof without walls, seen by one pair
  EXPECT_GE(scene.kept(kThin), 0.995);
}

TEST(Cleaning, KeepsGroundThatOnePairSaw) {
  Scene scene(6);
  scene.plane(0, 0, 20, 40, 0, 6, kGround);
  scene.plane(20, 0, 40, 40, 0, 1, kSinglePair, 0.5);
  for (int i = 0; i < 12; ++i)  // and islands of it, with nothing else in their columns
    scene.plane(45, 3 * i, 46.5, 3 * i + 1.5, 0, 1, kSinglePair);
  EXPECT_GE(scene.kept(kSinglePair), 0.97);  // all but the rim beside ground seen six times
}

TEST(Cleaning, NeighboursSupportAcrossTheBorder) {
  // A corner of ground of 16 voxels: an islet alone, part of the plane with the neighbour.
  Tile corner, plane;
  plane.offset_m = {-10, 0, 0};
  TilePoint point;
  point.views = 1;
  for (int x = 0; x < 100; ++x)
    for (int y = 0; y < 100; ++y) {
      point.position_m = {0.05f + 0.1f * x, 0.05f + 0.1f * y, 0};
      plane.points.push_back(point);
      if (x < 4 && y < 4) corner.points.push_back(point);
    }
  EXPECT_EQ(cleaned(corner, {}, kVoxel, kTrusted).points.size(), 0u);
  EXPECT_EQ(cleaned(corner, {&plane}, kVoxel, kTrusted).points.size(), 16u);
}

TEST(Cleaning, EmptyTile) { EXPECT_TRUE(cleaned(Tile{}, {}, kVoxel, kTrusted).points.empty()); }

class DeliverCloud : public testing::Test {
 protected:
  /// A slope over several tiles on both sides of zero, with outliers.
  void SetUp() override {
    options_.voxel_m = 0.25;
    options_.tile_m = 10;
    options_.max_memory_mb = 16;
    map_ = std::make_unique<ScratchMap>(options_);
    std::mt19937 random(7);
    std::uniform_real_distribution<double> at(-24.9, 24.9);
    for (unsigned view = 0; view < 4; ++view) {
      MapPoints points;
      for (int i = 0; i < 60000; ++i) {
        MapPoint point;
        const double x = at(random), y = at(random);
        const bool flying = i % 100 == 0;
        const double z = 0.2 * x + (flying ? 20 + at(random) / 2 : 0);
        point.position_m = Eigen::Vector3d(x, y, z).cast<float>();
        point.bgr[0] = flying ? kFlying : kGround;
        point.weight = 1;
        points.points.push_back(point);
      }
      map_->insert({0, view}, points);
    }
  }

  FuseOptions options_;
  std::unique_ptr<ScratchMap> map_;
};

TEST_F(DeliverCloud, GivesEveryTileOnceCleaned) {
  std::vector<TileIndex> seen;
  std::size_t ground = 0, flying = 0, raw = 0;
  for (const auto& [index, tile] : map_->tiles()) raw += tile.points.size();
  const Delivery delivery = deliverCloud(*map_, options_, [&](const Tile& tile) {
    seen.push_back(tile.index);
    ground += Scene::count(tile, kGround);
    flying += Scene::count(tile, kFlying);
    for (const TilePoint& point : tile.points) {
      if (point.bgr[0] != kGround) continue;
      ASSERT_NEAR(point.position_m.z(), 0.2 * (tile.offset_m.x() + point.position_m.x()), 2e-4);
    }
  });
  EXPECT_EQ(seen, map_->indices());
  EXPECT_EQ(delivery.points, ground + flying);
  EXPECT_EQ(delivery.tiles, seen.size());
  EXPECT_EQ(delivery.points + delivery.flying, raw);
  EXPECT_GT(ground, 39500u);  // of 200 x 200 voxels, the outermost not all hit
  EXPECT_LT(static_cast<double>(flying), 0.05 * 2400);
}

TEST_F(DeliverCloud, LeavesOutWhatTooFewSaw) {
  options_.min_views = 4;
  const Delivery four = deliverCloud(*map_, options_, [](const Tile& tile) {
    for (const TilePoint& point : tile.points) ASSERT_GE(point.views, 4);
  });
  EXPECT_GT(four.points, 0u);
  EXPECT_GT(four.uncertain, 0u);
  options_.min_confidence = 1e6;
  EXPECT_EQ(deliverCloud(*map_, options_, [](const Tile&) { FAIL(); }).points, 0u);
}

TEST_F(DeliverCloud, GivesTheSameWithLittleMemory) {
  // With room for nothing, tiles are read again for each neighbour; the result is the same.
  std::size_t roomy = 0, tight = 0;
  options_.max_memory_mb = 1000;
  deliverCloud(*map_, options_, [&](const Tile& tile) { roomy += tile.points.size(); });
  options_.max_memory_mb = 0;
  deliverCloud(*map_, options_, [&](const Tile& tile) { tight += tile.points.size(); });
  EXPECT_EQ(roomy, tight);
}

}  // namespace
}  // namespace cf
