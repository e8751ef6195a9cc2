// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/deliver/dsm.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <random>

#include "cf/base/error.h"
#include "cf/formats/geotiff.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

constexpr double kVoxel_m = 0.1, kTile_m = 40;

/// A slope with a flat-roofed house on it, in the world's ENU.
double surface(double x, double y) {
  const bool house = std::abs(x - 20) < 8 && std::abs(y + 5) < 6;
  return house ? 14 : 0.1 * x + 2 * std::sin(y / 15);
}
bool nearWall(double x, double y) {
  const double dx = std::abs(std::abs(x - 20) - 8), dy = std::abs(std::abs(y + 5) - 6);
  return (dx < 0.3 && std::abs(y + 5) < 6.3) || (dy < 0.3 && std::abs(x - 20) < 8.3);
}
bool inLake(double x, double y) { return std::hypot(x + 30, y - 10) < 5; }

/// The cloud of that scene, [-70, 70] x [-30, 30]: noise, walls, a few flying points.
DirectoryTileStore cloudOf(const std::filesystem::path& folder) {
  auto store = DirectoryTileStore::create(folder, kTile_m, kVoxel_m);
  std::mt19937 random(1);
  std::normal_distribution<float> noise(0, 0.03F);
  std::uniform_real_distribution<double> within(-0.5, 0.5);
  std::map<TileIndex, Tile> tiles;
  const auto add = [&](double x, double y, double z, int views, float confidence) {
    const TileIndex index{static_cast<std::int32_t>(std::floor(x / kTile_m)),
                          static_cast<std::int32_t>(std::floor(y / kTile_m))};
    Tile& tile = tiles[index];
    tile.index = index;
    tile.offset_m = Eigen::Vector3d(index.x * kTile_m, index.y * kTile_m, 0);
    TilePoint p;
    p.position_m = (Eigen::Vector3d(x, y, z) - tile.offset_m).cast<float>();
    p.views = static_cast<std::uint16_t>(views);
    p.confidence = confidence;
    tile.points.push_back(p);
  };
  for (int i = -700; i < 700; ++i)
    for (int j = -300; j < 300; ++j) {
      const double x = kVoxel_m * (i + 0.5 + within(random)),
                   y = kVoxel_m * (j + 0.5 + within(random));
      if (inLake(x, y)) continue;
      add(x, y, surface(x, y) + static_cast<double>(noise(random)), 5, 10);
      if (random() % 500 == 0) add(x, y, surface(x, y) + 3, 1, 1);
    }
  for (double y = -11; y < 1; y += kVoxel_m)
    for (double z = 2; z < 14; z += 0.3) add(12, y, z, 2, 3);
  for (const auto& [index, tile] : tiles) store.save(tile);
  store.flush();
  return store;
}

TEST(Dsm, IsTheSurfaceOnANorthUpRasterInUtm) {
  const support::TempFolder folder;
  DirectoryTileStore cloud = cloudOf(folder / "cloud");
  // Far from the zone's central meridian: grid north is 1.8 degrees off.
  const GridFrame grid(LocalFrame(46.95, 11.4, 540), HeightDatum::kMsl);
  DsmBuilder builder(grid, kVoxel_m);
  EXPECT_TRUE(builder.empty());
  for (const TileIndex index : cloud.indices()) builder.add(*cloud.load(index));
  builder.write(cloud, folder / "dsm.tif");

  const GeoTiffReader dsm(folder / "dsm.tif");
  const GeoTiffGrid& raster = dsm.grid();
  EXPECT_GT(raster.width, DsmBuilder::kWindow) << "the seam between windows is tested too";
  const cv::Mat heights = dsm.heights({0, 0, raster.width, raster.height});
  std::vector<double> errors;
  int inside = 0, lake = 0, filled_lake = 0, outside = 0;
  for (int row = 0; row < raster.height; ++row)
    for (int column = 0; column < raster.width; ++column) {
      const Eigen::Vector3d p = grid.toWorld({raster.left_m + (column + 0.5) * raster.cell_m,
                                              raster.top_m - (row + 0.5) * raster.cell_m, 540});
      const float z = heights.at<float>(row, column);
      if (std::abs(p.x()) > 70.1 || std::abs(p.y()) > 30.1) {
        outside += !std::isnan(z);
      } else if (std::hypot(p.x() + 30, p.y() - 10) < 3) {
        ++lake;
        filled_lake += !std::isnan(z);
      } else if (std::abs(p.x()) < 69.5 && std::abs(p.y()) < 29.5 &&
                 std::hypot(p.x() + 30, p.y() - 10) > 5.5 && !nearWall(p.x(), p.y())) {
        ++inside;
        if (std::isnan(z)) continue;
        const Eigen::Vector3d truth = grid.toGrid({p.x(), p.y(), surface(p.x(), p.y())});
        errors.push_back(static_cast<double>(z) - truth.z());
      }
    }
  EXPECT_EQ(outside, 0);
  EXPECT_EQ(filled_lake, 0) << "of " << lake << " cells far from any shore";
  EXPECT_GT(static_cast<double>(errors.size()), 0.999 * inside);
  std::vector<double> magnitudes;
  double mean = 0;
  for (const double e : errors) {
    magnitudes.push_back(std::abs(e));
    mean += e / static_cast<double>(errors.size());
  }
  std::sort(magnitudes.begin(), magnitudes.end());
  EXPECT_NEAR(mean, 0, 0.003);
  EXPECT_LT(1.4826 * magnitudes[magnitudes.size() / 2], 0.03) << "better than the points' noise";
  EXPECT_LT(magnitudes[magnitudes.size() * 999 / 1000], 0.12);

  const auto info = support::runCommand("gdalinfo -json '" + (folder / "dsm.tif").string() + "'");
  if (info.status != 0) GTEST_SKIP() << "gdalinfo is not installed";
  const auto json = nlohmann::json::parse(info.output);
  EXPECT_EQ(json["stac"]["proj:epsg"], 32632);
  EXPECT_EQ(json["metadata"][""]["HEIGHT_DATUM"], "msl");
  EXPECT_EQ(json["metadata"][""]["HOLES_FILLED_M"], "1.000");
  EXPECT_EQ(json["bands"][0]["unit"], "m");
  EXPECT_FALSE(json["bands"][0]["overviews"].empty());
}

TEST(Dsm, OfARelativeMapHasNoReferenceSystem) {
  const support::TempFolder folder;
  auto cloud = DirectoryTileStore::create(folder / "cloud", kTile_m, kVoxel_m);
  Tile tile;
  for (int i = 0; i < 2500; ++i) {
    TilePoint p;
    p.position_m = {0.1F * static_cast<float>(i % 50), 0.1F * static_cast<float>(i / 50), 3};
    p.views = 2;
    p.confidence = 1;
    tile.points.push_back(p);
  }
  cloud.save(tile);
  const GridFrame grid;
  DsmBuilder builder(grid, kVoxel_m);
  builder.add(tile);
  builder.write(cloud, folder / "dsm.tif");
  const GeoTiffReader dsm(folder / "dsm.tif");
  EXPECT_TRUE(dsm.grid().crs.empty());
  EXPECT_NEAR(dsm.grid().left_m, 0, 0.101);
  EXPECT_FLOAT_EQ(dsm.heights({20, 20, 1, 1}).at<float>(0, 0), 3);
}

TEST(Dsm, SaysWhatIsMissing) {
  const support::TempFolder folder;
  auto cloud = DirectoryTileStore::create(folder / "cloud", kTile_m, kVoxel_m);
  const GridFrame grid;
  DsmBuilder builder(grid, kVoxel_m);
  EXPECT_THROW(builder.write(cloud, folder / "dsm.tif"), RunError);
  Tile tile;
  tile.points.resize(3);
  builder.add(tile);
  EXPECT_THROW(builder.write(cloud, folder / "dsm.tif"), RunError);  // it was never saved
  EXPECT_FALSE(std::filesystem::exists(folder / "dsm.tif"));
}

}  // namespace
}  // namespace cf
