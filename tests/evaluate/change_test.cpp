// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// Two made-up runs of one place: what stands between their surfaces is known exactly.
#include "cf/evaluate/change.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <random>
#include <string>

#include "cf/base/error.h"
#include "cf/formats/atomic_file.h"
#include "cf/formats/float_raster.h"
#include "cf/formats/tile_store.h"
#include "cf/geodesy/grid_frame.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr double kCell_m = 0.1, kSide_m = 60, kNoise_m = 0.02;

/// Hills and a hall, about the middle of the place; what was built since, if anything.
double surface(double x, double y, bool built) {
  double z = 2 * std::sin(x / 9) + 1.5 * std::cos(y / 7) + 0.02 * x;
  if (std::abs(x + 12) < 6 && std::abs(y - 8) < 4) z = 7;
  if (built && std::abs(x - 10) < 3 && std::abs(y + 9) < 2.5) z += 3;
  return z;
}

/// p_a = middle + shift + scale R (p_b - middle)
struct Motion {
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d turn_deg = Eigen::Vector3d::Zero();
  double scale = 1;

  Eigen::Vector3d operator()(const Eigen::Vector3d& p) const {
    const Eigen::Vector3d turn = turn_deg * M_PI / 180;
    const Eigen::Vector3d turned =
        turn.norm() > 0 ? Eigen::AngleAxisd(turn.norm(), turn.normalized()) * p : p;
    return shift_m + scale * turned;
  }
};

/// Writes the folder of a run whose map is off by `motion` (p_true = motion(p_map)).
void writeRun(const fs::path& folder, const Motion& motion, bool built, std::uint32_t seed,
              double north_of_place_m = 0) {
  const LocalFrame world(47, 9.01, 500);
  const GridFrame grid(world, HeightDatum::kEllipsoid);
  fs::create_directories(folder);
  writeFileAtomically(folder / "world.json",
                      R"({"origin": {"lat": 47, "lon": 9.01, "h": 500}, "utm": "32N"})");
  const Eigen::Vector3d middle = grid.toGrid({0, 0, 0});
  const int n = static_cast<int>(kSide_m / kCell_m);
  FloatRaster dsm;
  dsm.values.create(n, n, CV_32FC1);
  const double west = middle.x() - kSide_m / 2, north = middle.y() + north_of_place_m + kSide_m / 2;
  dsm.geotransform = {west, kCell_m, 0, north, 0, -kCell_m};
  dsm.crs_wkt_or_epsg = "EPSG:32632";
  dsm.metadata = {{"HEIGHT_DATUM", "ellipsoid"}};
  Tile tile;
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, kNoise_m);
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      Eigen::Vector3d p((x + 0.5) * kCell_m - kSide_m / 2, kSide_m / 2 - (y + 0.5) * kCell_m, 0);
      p.y() += north_of_place_m;
      for (int k = 0; k < 6; ++k) {
        const Eigen::Vector3d truth = motion(p);
        p.z() += surface(truth.x(), truth.y(), built) - truth.z();
      }
      p.z() += noise(random);
      const Eigen::Vector3d at = middle + p;
      dsm.values.at<float>(y, x) = static_cast<float>(at.z());
      TilePoint point;
      point.position_m = grid.toWorld(at).cast<float>();
      point.confidence = static_cast<float>(1 / (kNoise_m * kNoise_m));
      point.views = 3;
      tile.points.push_back(point);
    }
  writeFloatRaster(folder / "dsm.tif", dsm);
  DirectoryTileStore cloud = DirectoryTileStore::create(folder / "cloud", 1000, kCell_m);
  cloud.save(tile);
  cloud.flush();
}

const Motion kOff = {{1.7, -2.3, 4.1}, {0.3, -0.2, 0.4}, 1.004};

Json changeOf(const support::TempFolder& temp, const ChangeOptions& options = {}) {
  ChangeOptions complete = options;
  complete.outdir = temp / "change";
  return Json::parse(evaluateChange(temp / "a", temp / "b", complete));
}

void expectRefusal(const support::TempFolder& temp, const std::string& naming) {
  try {
    changeOf(temp);
    ADD_FAILURE() << "not refused: " << naming;
  } catch (const RunError& e) {
    const std::string line = e.what();
    EXPECT_NE(line.find(naming), std::string::npos) << line;
    EXPECT_EQ(line.find('\n'), std::string::npos) << line;
  }
}

TEST(Change, RegistrationFindsTheMotionWithinItsSigma) {
  const support::TempFolder temp;
  writeRun(temp / "a", {}, false, 1);
  writeRun(temp / "b", kOff, false, 2);
  const Json change = changeOf(temp);
  const Json& r = change["registration"];
  // The shift is told about the middle of the common ground, centimetres from that of the place.
  for (int k = 0; k < 3; ++k) {
    const auto i = static_cast<std::size_t>(k);
    EXPECT_NEAR(r["rotation_deg"][i].get<double>(), kOff.turn_deg[k],
                5 * r["rotation_sigma_deg"][i].get<double>());
    EXPECT_LT(r["rotation_sigma_deg"][i].get<double>(), 0.02);
    EXPECT_LT(r["shift_sigma_m"][i].get<double>(), 0.02);
    EXPECT_NEAR(r["shift_m"][i].get<double>(), kOff.shift_m[k], 0.05);
  }
  EXPECT_NEAR(r["scale"].get<double>(), kOff.scale, 5 * r["scale_sigma"].get<double>());
  EXPECT_LT(r["scale_sigma"].get<double>(), 3e-4);
  EXPECT_GT(r["stable_share"].get<double>(), 0.95);
  // Nothing has changed.
  EXPECT_EQ(change["changes_found"], 0);
  const Json& stable = change["stable_ground"];
  // Between four cells of B its noise has two thirds of the size.
  EXPECT_NEAR(stable["nmad_m"].get<double>(), kNoise_m * std::sqrt(1 + 4 / 9.0), 0.05 * kNoise_m);
  EXPECT_NEAR(stable["beyond_2_sigma"].get<double>(), 0.0455, 0.01);
  EXPECT_LT(stable["beyond_3_sigma"].get<double>(), 0.005);
}

TEST(Change, WhatWasBuiltHasItsPlaceAreaAndVolume) {
  const support::TempFolder temp;
  writeRun(temp / "a", {}, false, 3);
  writeRun(temp / "b", kOff, true, 4);
  const Json change = changeOf(temp);
  ASSERT_EQ(change["changes_found"], 1) << change.dump(1);
  const Json& built = change["changes"][0];
  EXPECT_EQ(built["kind"], "gain");
  EXPECT_NEAR(built["area_m2"].get<double>(), 30, 2);
  EXPECT_NEAR(built["mean_height_m"].get<double>(), 3, 0.1);
  EXPECT_NEAR(built["volume_m3"].get<double>(), 90, 3 * built["volume_sigma_m3"].get<double>());
  EXPECT_LT(built["volume_sigma_m3"].get<double>(), 6);
  const Eigen::Vector3d p = LocalFrame(47, 9.01, 500).toEnu(built["lat"], built["lon"], 500);
  EXPECT_NEAR(p.x(), 10, 0.3);
  EXPECT_NEAR(p.y(), -9, 0.3);
  EXPECT_EQ(change["loss"]["changes"], 0);
  // Seen the other way round it was taken away.
  ChangeOptions options;
  options.outdir = temp / "back";
  const Json back = Json::parse(evaluateChange(temp / "b", temp / "a", options));
  EXPECT_EQ(back["gain"]["changes"], 0);
  EXPECT_NEAR(back["loss"]["volume_m3"].get<double>(), -90, 5);

  const FloatRaster difference = readFloatRaster(temp / "change" / "difference.tif"),
                    sigma = readFloatRaster(temp / "change" / "sigma.tif"),
                    significance = readFloatRaster(temp / "change" / "significance.tif");
  EXPECT_EQ(difference.crs_wkt_or_epsg, "EPSG:32632");
  ASSERT_EQ(difference.values.size(), significance.values.size());
  const auto& g = *difference.geotransform;
  const auto at = [&](const FloatRaster& raster, double east, double north) {
    return static_cast<double>(raster.values.at<float>(static_cast<int>((g[3] - north) / -g[5]),
                                                       static_cast<int>((east - g[0]) / g[1])));
  };
  const double e = built["easting"], n = built["northing"];
  EXPECT_NEAR(at(difference, e, n), 3, 0.1);
  EXPECT_NEAR(at(significance, e, n), at(difference, e, n) / at(sigma, e, n), 1e-3);
  EXPECT_GT(at(significance, e, n), 20);
  EXPECT_TRUE(fs::exists(temp / "change" / "change.png"));
  EXPECT_TRUE(fs::exists(temp / "change" / "change.json"));
}

TEST(Change, TheCellCanBeCoarser) {
  const support::TempFolder temp;
  writeRun(temp / "a", {}, false, 5);
  writeRun(temp / "b", kOff, true, 6);
  ChangeOptions options;
  options.cell_m = 0.4;
  const Json change = changeOf(temp, options);
  EXPECT_DOUBLE_EQ(change["cell_m"].get<double>(), 0.4);
  ASSERT_EQ(change["gain"]["changes"], 1) << change.dump(1);
  EXPECT_NEAR(change["gain"]["volume_m3"].get<double>(), 90, 12);
  EXPECT_LT(change["stable_ground"]["nmad_m"].get<double>(), 0.015);
}

TEST(Change, WhatOneViewSawIsNoMeasurement) {
  const support::TempFolder temp;
  writeRun(temp / "a", {}, false, 7);
  writeRun(temp / "b", kOff, true, 8);
  ChangeOptions options;
  options.min_views = 4;
  options.outdir = temp / "change";
  EXPECT_THROW(evaluateChange(temp / "a", temp / "b", options), RunError);
}

TEST(Change, RunsThatCannotBeComparedAreRefusedInOneLine) {
  const support::TempFolder temp;
  writeRun(temp / "a", {}, false, 9);
  writeRun(temp / "b", kOff, false, 10, 500);
  expectRefusal(temp, "cannot be compared");
  writeRun(temp / "b", kOff, false, 10, 57);
  expectRefusal(temp, "in common");
  // Ground that is alike, but a quarter smaller.
  writeRun(temp / "b", {{0, 0, 0}, {0, 0, 0}, 1.25}, false, 10);
  expectRefusal(temp, "cannot be compared");
  fs::remove(temp / "b" / "dsm.tif");
  expectRefusal(temp, "deliver.dsm");
  writeFileAtomically(temp / "b" / "world.json", R"({"origin": null})");
  expectRefusal(temp, "no place on earth");
}

}  // namespace
}  // namespace cf
