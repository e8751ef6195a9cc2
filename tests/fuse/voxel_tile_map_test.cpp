// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/fuse/voxel_tile_map.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "cf/base/error.h"
#include "fuse/scratch_map.h"

namespace cf {
namespace {

using test::ScratchMap;

FuseOptions options(double voxel_m = 0.5, double tile_m = 10) {
  FuseOptions result;
  result.voxel_m = voxel_m;
  result.tile_m = tile_m;
  return result;
}

MapPoint pointAt(double x, double y, double z, float weight = 1, int grey = 100) {
  MapPoint point;
  point.position_m = Eigen::Vector3d(x, y, z).cast<float>();
  std::fill(point.bgr, point.bgr + 3, static_cast<std::uint8_t>(grey));
  point.weight = weight;
  return point;
}

/// Around the world's origin.
MapPoints together(std::vector<MapPoint> points) {
  return {Eigen::Vector3d::Zero(), std::move(points)};
}

MapPoints randomPoints(int n, double extent_m, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> at(-extent_m, extent_m);
  std::uniform_real_distribution<float> weight(0.1f, 10.f);
  std::vector<MapPoint> points;
  for (int i = 0; i < n; ++i)
    points.push_back(pointAt(at(random), at(random), at(random) / 10, weight(random),
                             static_cast<int>(random() % 256)));
  return together(points);
}

Eigen::Vector3d world(const Tile& tile, const TilePoint& point) {
  return tile.offset_m + point.position_m.cast<double>();
}

TEST(TileMap, WeightedMeansOfOneVoxel) {
  ScratchMap map(options());
  map.insert({0, 0}, together({pointAt(1.1, 2.1, 3.1, 1, 10), pointAt(1.3, 2.1, 3.4, 3, 50)}));
  map.insert({0, 1}, together({pointAt(1.1, 2.2, 3.1, 1, 0)}));
  ASSERT_EQ(map.indices().size(), 1u);
  const Tile tile = map.tile({0, 0});
  ASSERT_EQ(tile.points.size(), 1u);
  EXPECT_TRUE(world(tile, tile.points[0]).isApprox(Eigen::Vector3d(1.22, 2.12, 3.28), 1e-5));
  EXPECT_EQ(tile.points[0].bgr[0], 32);  // (10 + 150 + 0) / 5
  EXPECT_EQ(tile.points[0].views, 2);
  EXPECT_FLOAT_EQ(tile.points[0].confidence, 5);
}

TEST(TileMap, FloorsNegativeCoordinates) {
  ScratchMap map(options());
  map.insert({0, 0}, together({pointAt(-0.01, 0.01, -0.01), pointAt(0.01, -10.0, 0.01),
                               pointAt(-10.0, -10.01, 5), pointAt(10, 30, 0)}));
  ASSERT_EQ(map.indices(), (std::vector<TileIndex>{{-1, -2}, {-1, 0}, {0, -1}, {1, 3}}));
  const Tile west = map.tile({-1, 0});
  EXPECT_EQ(west.offset_m, Eigen::Vector3d(-10, 0, 0));
  EXPECT_NEAR(west.points[0].position_m.x(), 9.99, 1e-5);
  EXPECT_NEAR(west.points[0].position_m.z(), -0.01, 2e-5);
}

TEST(TileMap, VoxelsAboveAndBelowZeroAreDistinct) {
  ScratchMap map(options());
  map.insert({0, 0}, together({pointAt(1.1, 1.1, -0.1), pointAt(1.1, 1.1, 0.1)}));
  EXPECT_EQ(map.tile({0, 0}).points.size(), 2u);
}

TEST(TileMap, CountsDepthFramesNotPoints) {
  ScratchMap map(options());
  const MapPoints twice = together({pointAt(1, 1, 1), pointAt(1.1, 1, 1)});
  map.insert({0, 7}, twice);
  map.insert({0, 7}, twice);
  map.insert({1, 7}, twice);
  EXPECT_EQ(map.tile({0, 0}).points[0].views, 2);
  EXPECT_FLOAT_EQ(map.tile({0, 0}).points[0].confidence, 6);
}

TEST(FuseOptions, ResolvedChoosesOnlyWhatIsAutomatic) {
  const FuseOptions automatic = FuseOptions{}.resolved(0.055);
  EXPECT_EQ(automatic.voxel_m, 0.055);
  EXPECT_EQ(automatic.tile_m, 17);
  EXPECT_EQ(options(0.5, 10).resolved(0.055).voxel_m, 0.5);
  EXPECT_EQ(options(0.5, 10).resolved(0.055).tile_m, 10);
  EXPECT_EQ(FuseOptions{}.resolved(0.001).tile_m, 1);
}

TEST(TileMap, OrderOfInsertionDoesNotMatter) {
  MapPoints points = randomPoints(50000, 15, 1);
  ScratchMap forward(options()), shuffled(options());
  forward.insert({0, 0}, points);
  std::shuffle(points.points.begin(), points.points.end(), std::mt19937(2));
  shuffled.insert({0, 0}, points);
  ASSERT_EQ(forward.indices(), shuffled.indices());
  for (const auto& [index, a] : forward.tiles()) {
    const Tile b = shuffled.tile(index);
    ASSERT_EQ(a.points.size(), b.points.size());
    for (std::size_t i = 0; i < a.points.size(); ++i) {
      // A thousandth of the voxel's side, which is three times as high.
      EXPECT_LT((a.points[i].position_m - b.points[i].position_m).norm(), 5e-4);
      EXPECT_LE(std::abs(a.points[i].bgr[0] - b.points[i].bgr[0]), 1);
    }
  }
}

TEST(TileMap, FarFromTheWorldsOriginNothingIsLost) {
  const MapPoints near = randomPoints(20000, 15, 4);
  MapPoints far = near;
  far.origin_m = {50000, -30000, 1500};  // whole tiles and voxels
  ScratchMap here(options()), there(options());
  here.insert({0, 0}, near);
  there.insert({0, 0}, far);
  ASSERT_EQ(here.indices().size(), there.indices().size());
  for (const auto& [index, a] : here.tiles()) {
    const Tile b = there.tile({index.x + 5000, index.y - 3000});
    ASSERT_EQ(a.points.size(), b.points.size());
    for (std::size_t i = 0; i < a.points.size(); ++i)
      EXPECT_LT((world(a, a.points[i]) + far.origin_m - world(b, b.points[i])).norm(), 2e-4);
  }
}

// Reference: the same sums in double over a plain sort of the cells, three sides high.
TEST(TileMap, AgreesWithDirectSums) {
  const MapPoints points = randomPoints(20000, 9.9, 3);
  ScratchMap map(options());
  map.insert({0, 0}, points);
  struct Sum {
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
    double w = 0;
  };
  std::map<std::array<long, 3>, Sum> sums;
  const auto cell = [](const Eigen::Vector3d& p) {
    return std::array<long, 3>{std::lround(std::floor(p.x() / 0.5)),
                               std::lround(std::floor(p.y() / 0.5)),
                               std::lround(std::floor(p.z() / 1.5))};
  };
  for (const MapPoint& point : points.points) {
    const Eigen::Vector3d p = points.world(point);
    Sum& sum = sums[cell(p)];
    sum.p += static_cast<double>(point.weight) * p;
    sum.w += static_cast<double>(point.weight);
  }
  std::size_t voxels = 0;
  for (const auto& [index, tile] : map.tiles()) {
    voxels += tile.points.size();
    for (const TilePoint& point : tile.points) {
      const auto found = sums.find(cell(world(tile, point)));
      ASSERT_NE(found, sums.end());
      EXPECT_LT((world(tile, point) - found->second.p / found->second.w).norm(), 5e-5);
      EXPECT_NEAR(point.confidence, found->second.w, 1e-5 * found->second.w);
    }
  }
  EXPECT_EQ(voxels, sums.size());
}

/// A survey going back and forth over 40 tiles, with many voxels. Each frame falls on five tiles
/// and comes in two parts.
void flyOver(TileMap& map, int passes) {
  for (int pass = 0; pass < passes; ++pass)
    for (int strip = 0; strip < 40; ++strip) {
      const FrameId frame{0, static_cast<std::uint32_t>(pass * 100 + strip)};
      std::mt19937 random(frame.index);
      std::uniform_real_distribution<double> at(-25, 25);
      for (int part = 0; part < 2; ++part) {
        std::vector<MapPoint> points;
        for (int i = 0; i < 4000; ++i)
          points.push_back(pointAt(at(random), 5 + 0.2 * at(random), at(random),
                                   1 + static_cast<float>(i % 3), i % 256));
        map.insert(frame, {Eigen::Vector3d(10 * strip - 195, 0, 0), points});
      }
    }
}

void expectSame(const ScratchMap& a, const ScratchMap& b) {
  ASSERT_EQ(a.indices(), b.indices());
  for (const auto& [index, expected] : a.tiles()) {
    const Tile tile = b.tile(index);
    ASSERT_EQ(tile.points.size(), expected.points.size());
    for (std::size_t i = 0; i < tile.points.size(); ++i) {
      const TilePoint &p = tile.points[i], &q = expected.points[i];
      ASSERT_EQ(p.position_m, q.position_m);
      ASSERT_TRUE(std::equal(p.bgr, p.bgr + 3, q.bgr));
      ASSERT_EQ(p.views, q.views);
      ASSERT_EQ(p.confidence, q.confidence);
    }
  }
}

TEST(TileMap, TilesThatLeaveMemoryComeBackAsTheyWere) {
  FuseOptions small = options(0.25);
  small.max_memory_mb = 2;
  FuseOptions large = small;
  large.max_memory_mb = 4096;
  ScratchMap bounded(small), unbounded(large);
  flyOver(bounded, 3);
  flyOver(unbounded, 3);
  EXPECT_LE(bounded.stats().resident_bytes, 2u << 20);
  EXPECT_GT(bounded.stats().reloaded, 100u);
  EXPECT_EQ(unbounded.stats().reloaded, 0u);
  EXPECT_GT(unbounded.stats().resident_bytes, 12u << 20);
  expectSame(bounded, unbounded);
  unbounded.leaveMemory();
  EXPECT_EQ(unbounded.stats().resident_bytes, 0u);
  expectSame(bounded, unbounded);
}

TEST(TileMap, TheResultDoesNotDependOnTheThreads) {
  ScratchMap one(options(0.25)), many(options(0.25));
  {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, 1);
    flyOver(one, 1);
  }
  flyOver(many, 1);
  expectSame(one, many);
}

TEST(TileMap, ViewsAreCountedBeyondTheStampsOfAVoxel) {
  ScratchMap map(options());
  map.insert({1, 0}, together({pointAt(1, 1, 1)}));
  for (std::uint32_t frame = 0; frame < 5000; ++frame)
    for (int part = 0; part < 2; ++part) {
      map.insert({0, frame}, together({pointAt(2, 2, 2)}));
      if (frame == 254 || frame == 255) map.insert({0, frame}, together({pointAt(1, 1, 1)}));
    }
  const Tile tile = map.tile({0, 0});
  ASSERT_EQ(tile.points.size(), 2u);
  EXPECT_EQ(tile.points[0].views, 3);
  EXPECT_EQ(tile.points[1].views, 4095);
}

TEST(TileMap, AMeanStaysInItsVoxel) {
  // Means at the faces of the voxels, far from the tile's corner in z.
  ScratchMap map(options(0.01, 10));
  MapPoints points;
  points.origin_m = {0, 0, 900};
  for (int i = 1; i < 1000; i += 2)
    for (const float side : {-1e-5f, 1e-5f}) {
      const float edge = 0.01f * static_cast<float>(i);
      points.points.push_back(pointAt(edge + side, edge + side, 3 * (edge + side)));
    }
  map.insert({0, 0}, points);
  map.insert({0, 1}, points);
  std::size_t voxels = 0;
  for (const auto& [index, tile] : map.tiles()) {
    voxels += tile.points.size();
    for (const TilePoint& point : tile.points) {
      EXPECT_EQ(point.views, 2);
      const double x = 100 * world(tile, point).x();
      EXPECT_NEAR(std::abs(x - std::round(x)), 0.001, 0.0005);
    }
  }
  EXPECT_EQ(voxels, points.points.size());
}

TEST(TileMap, UnusablePointsAreCountedAndLeftOut) {
  ScratchMap map(options());
  const double nan = std::nan("");
  map.insert({0, 0}, together({pointAt(nan, 0, 0), pointAt(0, 0, nan), pointAt(1e30, 0, 0),
                               pointAt(0, 0, 1e12), pointAt(0, 0, 0, 0), pointAt(0, 0, 0, -1),
                               pointAt(0, 0, 0, static_cast<float>(nan)), pointAt(1, 1, 1)}));
  EXPECT_EQ(map.stats().dropped, 7u);
  EXPECT_EQ(map.stats().points, 1u);
  EXPECT_EQ(map.tile({0, 0}).points.size(), 1u);
}

TEST(TileMap, NeedsAVoxelSize) {
  EXPECT_THROW(ScratchMap(options(0)), UsageError);
  EXPECT_THROW(ScratchMap(options(11, 10)), UsageError);
  EXPECT_THROW(ScratchMap(options(0.009, 10)), UsageError);
}

TEST(TileMap, SaysThatItsScratchFolderCannotBeMade) {
  EXPECT_THROW(TileMap(options(), "/proc/nothing/here"), RunError);
}

TEST(TileMap, LeavesNothingInItsScratchFolder) {
  const support::TempFolder folder;
  {
    TileMap map(options(), folder / "scratch");
    map.insert({0, 0}, together({pointAt(1, 1, 1)}));
    map.leaveMemory();
    EXPECT_FALSE(std::filesystem::is_empty(folder / "scratch"));
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "scratch"));
}

}  // namespace
}  // namespace cf
