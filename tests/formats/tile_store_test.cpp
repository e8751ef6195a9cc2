// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/tile_store.h"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "cf/base/error.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

class TileStoreTest : public testing::Test {
 protected:
  static Tile tileAt(TileIndex index, int points) {
    Tile tile;
    tile.index = index;
    tile.offset_m = {index.x * 50.0, index.y * 50.0, 0};
    tile.points.resize(static_cast<std::size_t>(points));
    for (TilePoint& point : tile.points) point.views = 2;
    return tile;
  }

  const support::TempFolder scratch_;
  const fs::path folder_ = scratch_ / "cloud";
};

TEST_F(TileStoreTest, LoadsWhatItSaved) {
  DirectoryTileStore store = DirectoryTileStore::create(folder_, 50, 0.1);
  EXPECT_FALSE(store.load({0, 0}).has_value());
  store.save(tileAt({-1, 2}, 3));
  const auto tile = store.load({-1, 2});
  ASSERT_TRUE(tile.has_value());
  EXPECT_EQ(tile->index, (TileIndex{-1, 2}));
  EXPECT_EQ(tile->offset_m, Eigen::Vector3d(-50, 100, 0));
  EXPECT_EQ(tile->points.size(), 3u);
  EXPECT_TRUE(fs::exists(folder_ / "tiles" / "-1_2.pcd"));
}

TEST_F(TileStoreTest, ListNamesEveryTile) {
  DirectoryTileStore store = DirectoryTileStore::create(folder_, 50, 0.1);
  store.save(tileAt({1, 0}, 3));
  store.save(tileAt({-1, 7}, 5));
  store.save(tileAt({1, 0}, 4));
  store.flush();
  const auto json = nlohmann::json::parse(std::ifstream(folder_ / "tiles.json"));
  EXPECT_EQ(json["tile_size_m"], 50);
  EXPECT_EQ(json["voxel_size_m"], 0.1);
  ASSERT_EQ(json["tiles"].size(), 2u);
  EXPECT_EQ(json["tiles"][0]["file"], "tiles/-1_7.pcd");
  EXPECT_EQ(json["tiles"][0]["offset_m"], (std::vector<double>{-50, 350, 0}));
  EXPECT_EQ(json["tiles"][1]["points"], 4);
}

TEST_F(TileStoreTest, ReopenedAfterAKillItHasTilesThatWereNeverListed) {
  {
    DirectoryTileStore store = DirectoryTileStore::create(folder_, 50, 0.25);
    store.save(tileAt({0, 0}, 1));
    store.flush();
    store.save(tileAt({0, 1}, 2));
    std::ofstream(folder_ / "tiles" / "0_2.pcd.tmp") << "half a tile";
  }
  DirectoryTileStore store = DirectoryTileStore::open(folder_);
  EXPECT_EQ(store.tileSize(), 50);
  EXPECT_EQ(store.voxelSize(), 0.25);
  EXPECT_EQ(store.indices(), (std::vector<TileIndex>{{0, 0}, {0, 1}}));
  EXPECT_EQ(store.load({0, 1})->points.size(), 2u);
}

TEST_F(TileStoreTest, CreateStartsEmptyAndLeavesOtherFilesAlone) {
  DirectoryTileStore::create(folder_, 50, 0.1).save(tileAt({0, 0}, 1));
  std::ofstream(folder_ / "tiles" / "notes.txt") << "mine";
  DirectoryTileStore store = DirectoryTileStore::create(folder_, 20, 0.1);
  EXPECT_TRUE(store.indices().empty());
  EXPECT_FALSE(fs::exists(folder_ / "tiles" / "0_0.pcd"));
  EXPECT_TRUE(fs::exists(folder_ / "tiles" / "notes.txt"));
}

TEST_F(TileStoreTest, FailuresNameTheFile) {
  EXPECT_THROW(DirectoryTileStore::open(folder_), RunError);
  DirectoryTileStore store = DirectoryTileStore::create(folder_, 50, 0.1);
  store.save(tileAt({0, 0}, 1));
  fs::remove(folder_ / "tiles" / "0_0.pcd");
  try {
    store.load({0, 0});
    FAIL() << "a missing tile was loaded";
  } catch (const RunError& error) {
    EXPECT_NE(std::string(error.what()).find("0_0.pcd"), std::string::npos);
  }
  std::ofstream(folder_ / "tiles.json") << "{";
  EXPECT_THROW(DirectoryTileStore::open(folder_), RunError);
  std::ofstream(folder_ / "file") << "x";
  EXPECT_THROW(DirectoryTileStore::create(folder_ / "file", 50, 0.1), RunError);
}

}  // namespace
}  // namespace cf
