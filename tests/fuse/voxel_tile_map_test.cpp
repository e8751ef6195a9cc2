// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/fuse/voxel_tile_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "cf/base/error.h"
#include "fuse/memory_tile_store.h"

namespace cf {
namespace {

using test::MemoryTileStore;

FuseOptions options(double voxel_m = 0.5, double tile_m = 10) {
  FuseOptions result;
  result.voxel_m = voxel_m;
  result.tile_m = tile_m;
  return result;
}

MapPoint pointAt(double x, double y, double z, float weight = 1, int grey = 100) {
  MapPoint point;
  point.position_m = {x, y, z};
  std::fill(point.bgr, point.bgr + 3, static_cast<std::uint8_t>(grey));
  point.weight = weight;
  return point;
}

std::vector<MapPoint> randomPoints(int n, double extent_m, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> at(-extent_m, extent_m);
  std::uniform_real_distribution<float> weight(0.1f, 10.f);
  std::vector<MapPoint> points;
  for (int i = 0; i < n; ++i)
    points.push_back(pointAt(at(random), at(random), at(random) / 10, weight(random),
                             static_cast<int>(random() % 256)));
  return points;
}

Eigen::Vector3d world(const Tile& tile, const TilePoint& point) {
  return tile.offset_m + point.position_m.cast<double>();
}

TEST(TileMap, WeightedMeansOfOneVoxel) {
  MemoryTileStore store;
  TileMap map(options(), store);
  map.insert({0, 0}, {pointAt(1.1, 2.1, 3.1, 1, 10), pointAt(1.3, 2.1, 3.4, 3, 50)});
  map.insert({0, 1}, {pointAt(1.1, 2.2, 3.1, 1, 0)});
  map.flush();
  ASSERT_EQ(store.tiles.size(), 1u);
  const Tile& tile = store.tiles.at({0, 0});
  ASSERT_EQ(tile.points.size(), 1u);
  EXPECT_TRUE(world(tile, tile.points[0]).isApprox(Eigen::Vector3d(1.22, 2.12, 3.28), 1e-6));
  EXPECT_EQ(tile.points[0].bgr[0], 32);  // (10 + 150 + 0) / 5
  EXPECT_EQ(tile.points[0].views, 2);
  EXPECT_FLOAT_EQ(tile.points[0].confidence, 5);
}

TEST(TileMap, FloorsNegativeCoordinates) {
  MemoryTileStore store;
  TileMap map(options(), store);
  map.insert({0, 0}, {pointAt(-0.01, 0.01, -0.01), pointAt(0.01, -10.0, 0.01),
                      pointAt(-10.0, -10.01, 5), pointAt(10, 30, 0)});
  map.flush();
  ASSERT_EQ(store.indices(), (std::vector<TileIndex>{{-1, -2}, {-1, 0}, {0, -1}, {1, 3}}));
  const Tile& west = store.tiles.at({-1, 0});
  EXPECT_EQ(west.offset_m, Eigen::Vector3d(-10, 0, 0));
  EXPECT_NEAR(west.points[0].position_m.x(), 9.99, 1e-5);
  EXPECT_NEAR(west.points[0].position_m.z(), -0.01, 1e-6);
}

TEST(TileMap, VoxelsAboveAndBelowZeroAreDistinct) {
  MemoryTileStore store;
  TileMap map(options(), store);
  map.insert({0, 0}, {pointAt(1.1, 1.1, -0.1), pointAt(1.1, 1.1, 0.1)});
  map.flush();
  EXPECT_EQ(store.tiles.at({0, 0}).points.size(), 2u);
}

TEST(TileMap, CountsDepthFramesNotPoints) {
  MemoryTileStore store;
  TileMap map(options(), store);
  const std::vector<MapPoint> twice = {pointAt(1, 1, 1), pointAt(1.1, 1, 1)};
  map.insert({0, 7}, twice);
  map.insert({0, 7}, twice);
  map.insert({1, 7}, twice);
  map.flush();
  EXPECT_EQ(store.tiles.at({0, 0}).points[0].views, 2);
  EXPECT_FLOAT_EQ(store.tiles.at({0, 0}).points[0].confidence, 6);
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
  std::vector<MapPoint> points = randomPoints(50000, 15, 1);
  MemoryTileStore forward, shuffled;
  {
    TileMap map(options(), forward);
    map.insert({0, 0}, points);
    map.flush();
  }
  std::shuffle(points.begin(), points.end(), std::mt19937(2));
  {
    TileMap map(options(), shuffled);
    map.insert({0, 0}, points);
    map.flush();
  }
  ASSERT_EQ(forward.indices(), shuffled.indices());
  for (const auto& [index, a] : forward.tiles) {
    const Tile& b = shuffled.tiles.at(index);
    ASSERT_EQ(a.points.size(), b.points.size());
    for (std::size_t i = 0; i < a.points.size(); ++i) {
      EXPECT_LT((a.points[i].position_m - b.points[i].position_m).norm(), 3e-6);
      EXPECT_LE(std::abs(a.points[i].bgr[0] - b.points[i].bgr[0]), 1);
    }
  }
}

// Reference: the same sums in double over a plain sort of the cells, three sides high.
TEST(TileMap, AgreesWithDirectSums) {
  const std::vector<MapPoint> points = randomPoints(20000, 9.9, 3);
  MemoryTileStore store;
  TileMap map(options(), store);
  map.insert({0, 0}, points);
  map.flush();
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
  for (const MapPoint& point : points) {
    Sum& sum = sums[cell(point.position_m)];
    sum.p += static_cast<double>(point.weight) * point.position_m;
    sum.w += static_cast<double>(point.weight);
  }
  std::size_t voxels = 0;
  for (const auto& [index, tile] : store.tiles) {
    voxels += tile.points.size();
    for (const TilePoint& point : tile.points) {
      const auto found = sums.find(cell(world(tile, point)));
      ASSERT_NE(found, sums.end());
      EXPECT_LT((world(tile, point) - found->second.p / found->second.w).norm(), 3e-6);
      EXPECT_NEAR(point.confidence, found->second.w, 1e-5 * found->second.w);
    }
  }
  EXPECT_EQ(voxels, sums.size());
}

/// A survey going back and forth over 40 tiles, with many voxels.
void flyOver(TileMap& map, int passes) {
  for (int pass = 0; pass < passes; ++pass)
    for (int strip = 0; strip < 40; ++strip) {
      std::vector<MapPoint> points;
      std::mt19937 random(static_cast<unsigned>(pass * 100 + strip));
      std::uniform_real_distribution<double> at(0, 10);
      for (int i = 0; i < 8000; ++i)
        points.push_back(pointAt(10 * strip - 200 + at(random), at(random), 5 * at(random),
                                 1 + static_cast<float>(i % 3), i % 256));
      map.insert({0, static_cast<std::uint32_t>(pass * 100 + strip)}, points);
    }
}

TEST(TileMap, TilesThatLeaveMemoryComeBackWithNothingLost) {
  FuseOptions small = options(0.25);
  small.max_memory_mb = 16;
  FuseOptions large = small;
  large.max_memory_mb = 4096;
  MemoryTileStore bounded, unbounded;
  TileMap a(small, bounded), b(large, unbounded);
  flyOver(a, 3);
  flyOver(b, 3);
  EXPECT_LE(a.stats().resident_bytes, 16u << 20);
  EXPECT_GT(a.stats().reloaded, 40u);
  EXPECT_EQ(b.stats().reloaded, 0u);
  EXPECT_GT(b.stats().resident_bytes, 20u << 20);
  a.flush();
  b.flush();
  ASSERT_EQ(bounded.indices(), unbounded.indices());
  for (const auto& [index, expected] : unbounded.tiles) {
    const Tile& tile = bounded.tiles.at(index);
    ASSERT_EQ(tile.points.size(), expected.points.size());
    for (std::size_t i = 0; i < tile.points.size(); ++i) {
      const TilePoint &p = tile.points[i], &q = expected.points[i];
      ASSERT_LT((p.position_m - q.position_m).norm(), 1e-5);
      ASSERT_LE(std::abs(p.bgr[1] - q.bgr[1]), 1);
      ASSERT_EQ(p.views, q.views);
      ASSERT_FLOAT_EQ(p.confidence, q.confidence);
    }
  }
}

TEST(TileMap, AVoxelNeverSplitsThroughRounding) {
  // Means within a rounding error of the cell's faces, far from the tile's corner in z.
  FuseOptions fine = options(0.01, 1000);
  MemoryTileStore store;
  std::vector<MapPoint> points;
  for (int i = 1; i < 5000; i += 2)
    for (const double side : {-1e-9, 1e-9}) {
      const double edge = 0.01 * (90000 + i);
      points.push_back(pointAt(edge + side, edge + side, edge + side));
    }
  for (int round = 0; round < 2; ++round) {
    TileMap map(fine, store);  // the second merges with what the first saved
    map.insert({0, static_cast<std::uint32_t>(round)}, points);
    map.flush();
    std::size_t voxels = 0;
    for (const auto& [index, tile] : store.tiles) {
      voxels += tile.points.size();
      for (const TilePoint& point : tile.points) ASSERT_EQ(point.views, round + 1);
    }
    EXPECT_EQ(voxels, points.size());
  }
}

TEST(TileMap, UnusablePointsAreCountedAndLeftOut) {
  MemoryTileStore store;
  TileMap map(options(), store);
  const double nan = std::nan("");
  map.insert({0, 0},
             {pointAt(nan, 0, 0), pointAt(0, 0, nan), pointAt(1e300, 0, 0), pointAt(0, 0, 1e12),
              pointAt(0, 0, 0, 0), pointAt(0, 0, 0, -1), pointAt(1, 1, 1)});
  EXPECT_EQ(map.stats().dropped, 6u);
  EXPECT_EQ(map.stats().points, 1u);
  map.flush();
  EXPECT_EQ(store.tiles.at({0, 0}).points.size(), 1u);
}

TEST(TileMap, NeedsAVoxelSize) {
  MemoryTileStore store;
  EXPECT_THROW(TileMap(options(0), store), UsageError);
  EXPECT_THROW(TileMap(options(11, 10), store), UsageError);
  EXPECT_THROW(TileMap(options(1e-6, 1000), store), UsageError);
}

}  // namespace
}  // namespace cf
