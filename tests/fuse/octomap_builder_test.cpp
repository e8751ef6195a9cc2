// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/fuse/octomap_builder.h"

#include <gtest/gtest.h>
#include <octomap/ColorOcTree.h>
#include <octomap/OcTree.h>

#include <cstdlib>
#include <memory>
#include <random>
#include <string>

#include "cf/base/error.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

constexpr double kResolution = 0.25;

OctomapOptions options() {
  OctomapOptions result;
  result.resolution_m = kResolution;
  return result;
}

/// A floor at z = -0.1 of 40 x 40 m about (-5, 3), green at x < -5 and red beyond.
Tile floorTile() {
  Tile tile;
  tile.offset_m = {-25, -17, -0.1};
  TilePoint point;
  point.views = 3;
  point.confidence = 2;
  for (int x = 0; x < 400; ++x)
    for (int y = 0; y < 400; ++y) {
      point.position_m = {0.05f + 0.1f * static_cast<float>(x),
                          0.05f + 0.1f * static_cast<float>(y), 0};
      point.bgr[1] = x < 200 ? 200 : 0;
      point.bgr[2] = x < 200 ? 0 : 150;
      tile.points.push_back(point);
    }
  return tile;
}

MapPoints pointsOf(const Tile& tile) {
  MapPoints points;
  points.origin_m = tile.offset_m;
  for (const TilePoint& point : tile.points) {
    MapPoint map_point;
    map_point.position_m = point.position_m;
    points.points.push_back(map_point);
  }
  return points;
}

std::vector<Eigen::Vector3d> positionsOf(const Tile& tile) {
  std::vector<Eigen::Vector3d> positions;
  for (const TilePoint& point : tile.points)
    positions.push_back(tile.offset_m + point.position_m.cast<double>());
  return positions;
}

octomap::point3d octo(const Eigen::Vector3d& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
}

class OctoMap : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / "cf_octomap_test" /
              testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    base_ = folder_ / "octomap";
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::unique_ptr<octomap::ColorOcTree> readColour() const {
    auto* any = octomap::AbstractOcTree::read(base_.string() + ".ot");
    return std::unique_ptr<octomap::ColorOcTree>(dynamic_cast<octomap::ColorOcTree*>(any));
  }

  fs::path folder_, base_;
};

TEST_F(OctoMap, PointsAreOccupiedRaysAreFreeTheRestIsUnknown) {
  OctoMapBuilder builder(options());
  const Tile tile = floorTile();
  const Eigen::Vector3d camera(-5, 3, 60.2);
  builder.addSurface(tile);
  builder.carve(camera, pointsOf(tile));
  builder.write(base_);

  const auto tree = readColour();
  ASSERT_TRUE(tree);
  EXPECT_EQ(tree->getResolution(), kResolution);
  for (const Eigen::Vector3d& position : positionsOf(tile)) {
    const auto* node = tree->search(octo(position));
    ASSERT_TRUE(node && tree->isNodeOccupied(node)) << position.transpose();
    if (std::abs(position.x() + 5) < 1) continue;  // the colours' border
    const octomap::ColorOcTreeNode::Color colour = node->getColor();
    const bool green = position.x() < -5;
    ASSERT_EQ(colour, octomap::ColorOcTreeNode::Color(green ? 0 : 150, green ? 200 : 0, 0));
  }
  // Along rays to points, down to the coarse cell that holds the surface.
  for (const double share : {0.05, 0.5, 0.9, 0.97}) {
    const auto* node = tree->search(octo(camera + share * (Eigen::Vector3d(-5, 3, -0.1) - camera)));
    ASSERT_TRUE(node) << share;
    EXPECT_FALSE(tree->isNodeOccupied(node)) << share;
  }
  for (const Eigen::Vector3d& nowhere :
       {Eigen::Vector3d(-5, 3, -2.5), Eigen::Vector3d(-5, 3, 70), Eigen::Vector3d(25, 3, 50)})
    EXPECT_EQ(tree->search(octo(nowhere)), nullptr) << nowhere.transpose();
}

// Against a brute-force walk in small steps along the rays.
TEST_F(OctoMap, RaysVisitExactlyTheCellsTheyCross) {
  OctomapOptions coarse = options();
  coarse.free_resolution_m = 1;
  OctoMapBuilder builder(coarse);
  ASSERT_EQ(builder.freeResolution(), 1);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> at(-30, 30);
  const Eigen::Vector3d camera(0.5, -0.3, 0.7);
  MapPoints points;
  points.origin_m = camera;
  points.points.resize(50);
  for (MapPoint& point : points.points)
    point.position_m = (Eigen::Vector3d(at(random), at(random), at(random)) - camera).cast<float>();
  builder.carve(camera, points);
  builder.write(base_);
  const auto tree = readColour();
  std::size_t checked = 0;
  for (const MapPoint& point : points.points) {
    const Eigen::Vector3d end = points.world(point);
    for (int i = 0; i < 200; ++i) {
      const Eigen::Vector3d p = camera + i / 200.0 * (end - camera);
      const auto cell = [](const Eigen::Vector3d& q) {
        return Eigen::Vector3d(std::floor(q.x()), std::floor(q.y()), std::floor(q.z()));
      };
      if (cell(p) == cell(end)) continue;
      ASSERT_NE(tree->search(octo(p)), nullptr) << p.transpose();
      ++checked;
    }
  }
  EXPECT_GT(checked, 9000u);
  double volume = 0, length = 0;
  for (auto leaf = tree->begin_leafs(); leaf != tree->end_leafs(); ++leaf) {
    EXPECT_FALSE(tree->isNodeOccupied(*leaf));
    volume += std::pow(leaf.getSize(), 3);
  }
  for (const MapPoint& point : points.points)
    length += (points.world(point) - camera).lpNorm<1>() + 3;
  EXPECT_LE(volume, length);  // a ray crosses at most |dx| + |dy| + |dz| + 3 cells of 1 m
}

TEST_F(OctoMap, RaysNeverEraseTheSurfaceAndStopAtIt) {
  OctoMapBuilder before(options()), after(options());
  const Tile tile = floorTile();
  MapPoints below = pointsOf(tile);  // flying points under the floor
  below.origin_m.z() -= 20;
  const Eigen::Vector3d camera(-5, 3, 40);
  after.addSurface(tile);
  after.carve(camera, below);
  before.carve(camera, below);
  before.addSurface(tile);
  for (const OctoMapBuilder* builder : {&before, &after}) {
    builder->write(base_);
    const auto tree = readColour();
    for (const Eigen::Vector3d& position : positionsOf(tile)) {
      const auto* node = tree->search(octo(position));
      ASSERT_TRUE(node && tree->isNodeOccupied(node));
    }
    const bool carved_below = tree->search(octomap::point3d(-5, 3, -8)) != nullptr;
    EXPECT_EQ(carved_below, builder == &before);
  }
}

TEST_F(OctoMap, BinaryTreeHoldsTheSameOccupancy) {
  OctoMapBuilder builder(options());
  const Tile tile = floorTile();
  builder.addSurface(tile);
  builder.carve({-5, 3, 60}, pointsOf(tile));
  builder.write(base_);
  const auto colour = readColour();
  octomap::OcTree binary(base_.string() + ".bt");
  ASSERT_GT(binary.size(), 1u);
  std::size_t leaves = 0;
  for (auto leaf = colour->begin_leafs(); leaf != colour->end_leafs(); ++leaf, ++leaves) {
    const auto* node = binary.search(leaf.getCoordinate());
    ASSERT_TRUE(node);
    ASSERT_EQ(binary.isNodeOccupied(node), colour->isNodeOccupied(*leaf));
  }
  EXPECT_GT(leaves, 160u * 160u / 2);
}

TEST_F(OctoMap, StockToolsReadBothFiles) {
  if (std::system("command -v convert_octree compare_octrees >/dev/null 2>&1") != 0)
    GTEST_SKIP() << "octomap-tools are not installed";
  OctoMapBuilder builder(options());
  const Tile tile = floorTile();
  builder.addSurface(tile);
  builder.carve({-5, 3, 60}, pointsOf(tile));
  builder.write(base_);
  const auto run = [&](const std::string& command) {
    return std::system(("cd '" + folder_.string() + "' && " + command + " >log 2>&1").c_str());
  };
  EXPECT_EQ(run("convert_octree octomap.ot from_colour.bt"), 0);
  EXPECT_EQ(run("convert_octree octomap.bt from_binary.ot"), 0);
  // compare_octrees knows OcTree alone and crashes on any ColorOcTree, OctoMap's own included.
  EXPECT_EQ(run("compare_octrees from_binary.ot from_binary.ot 2>&1 | grep -x 'KLD: 0'"), 0);
  octomap::OcTree ours(base_.string() + ".bt");
  octomap::OcTree theirs((folder_ / "from_colour.bt").string());
  EXPECT_GT(ours.size(), 1000u);
  EXPECT_TRUE(ours == theirs);
}

TEST_F(OctoMap, AnEmptyMapIsAFileToo) {
  OctoMapBuilder(options()).write(base_);
  const auto tree = readColour();
  ASSERT_TRUE(tree);
  EXPECT_EQ(tree->size(), 0u);
}

TEST_F(OctoMap, CountsWhatIsTooFar) {
  OctoMapBuilder builder(options());
  Tile tile = floorTile();
  tile.points.resize(2);
  tile.offset_m.x() = 1e5;
  builder.addSurface(tile);
  builder.carve({0, 0, 10}, pointsOf(tile));
  EXPECT_EQ(builder.stats().outside, 4u);
  EXPECT_EQ(builder.stats().occupied_cells, 0u);
}

TEST(OctomapOptions, ResolvesAndChecks) {
  OctomapOptions automatic;
  EXPECT_THROW(OctoMapBuilder{automatic}, UsageError);
  EXPECT_DOUBLE_EQ(automatic.resolved(0.07, 1e4).resolution_m, 0.28);
  EXPECT_DOUBLE_EQ(automatic.resolved(0.07, 1.5e5).resolution_m, 0.28);
  EXPECT_DOUBLE_EQ(automatic.resolved(0.07, 2e5).resolution_m, 0.56);
  EXPECT_DOUBLE_EQ(automatic.resolved(0.07, 2e6).resolution_m, 1.12);
  EXPECT_DOUBLE_EQ(options().resolved(0.07, 2e6).resolution_m, kResolution);
  EXPECT_DOUBLE_EQ(OctoMapBuilder(automatic.resolved(0.07, 1e4)).freeResolution(), 1.12);
}

TEST_F(OctoMap, UnwritableFolderIsAnError) {
  EXPECT_THROW(OctoMapBuilder(options()).write(folder_ / "no" / "such"), RunError);
}

}  // namespace
}  // namespace cf
