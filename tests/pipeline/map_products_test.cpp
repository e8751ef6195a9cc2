// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// cloud.las, dsm.tif and orthophoto.tif of a whole run against the scene that was photographed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "cf/base/log.h"
#include "cf/config/config.h"
#include "cf/formats/geotiff.h"
#include "cf/formats/ply.h"
#include "cf/formats/tum.h"
#include "cf/geodesy/utm.h"
#include "cf/pipeline/flight_run.h"
#include "support/synthetic_flight.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

class MapProducts : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    setLogQuiet(true);
    folder_ = std::make_unique<support::TempFolder>();
    Config config = Config::fromFile(support::writeSyntheticFlight(*folder_ / "in"));
    config.override("view.snapshots=0");
    runFlight(config, {out(""), false, "1.2.3"});
    drift_ = drift();
  }
  static void TearDownTestSuite() { folder_.reset(); }
  static fs::path out(const std::string& file) { return *folder_ / "out" / file; }

  /// The run's cameras against the true ones: GNSS noise on so few photos turns and shifts the map,
  /// and the products with it.
  static Eigen::Isometry3d drift() {
    const LocalFrame scene(support::SyntheticFlight::origin());
    const auto world = nlohmann::json::parse(support::fileText(out("world.json")))["origin"];
    const LocalFrame map(world["lat"], world["lon"], world["h"]);
    const Eigen::Isometry3d T_scene_map = scene.T_this_other(map);
    Eigen::Vector4d turn(0, 0, 0, 0);
    Eigen::Vector3d run_centre(0, 0, 0), true_centre(0, 0, 0);
    double count = 0;
    for (const auto& uav : support::syntheticFlight().uavs) {
      const auto poses = readTum(out("trajectories/" + uav.name + ".tum"));
      EXPECT_EQ(poses.size(), uav.photos.size());
      for (std::size_t i = 0; i < std::min(poses.size(), uav.photos.size()); ++i, ++count) {
        const Eigen::Isometry3d run = T_scene_map * poses[i].T_world_cam;
        const Eigen::Isometry3d& truth = uav.photos[i].truth.T_world_cam;
        Eigen::Quaterniond q(run.linear() * truth.linear().transpose());
        if (q.w() < 0) q.coeffs() = -q.coeffs();
        turn += q.coeffs();
        run_centre += run.translation();
        true_centre += truth.translation();
      }
    }
    Eigen::Isometry3d T(Eigen::Quaterniond(Eigen::Vector4d(turn.normalized())));
    T.translation() = run_centre / count - T.linear() * (true_centre / count);
    EXPECT_LT((run_centre - true_centre).norm() / count, 0.1);
    EXPECT_LT(Eigen::AngleAxisd(T.linear()).angle(), 0.03);
    return T;
  }

  /// From the zone of the place in the scene's world, by the plain definitions.
  static Eigen::Vector3d scenePlace(double easting_m, double northing_m, double height_m) {
    static const LocalFrame world(support::SyntheticFlight::origin());
    const auto p = utmToGeodetic({15, true}, easting_m, northing_m, height_m);
    return drift_.inverse() * world.toEnu(p.value());
  }

  static std::unique_ptr<support::TempFolder> folder_;
  static Eigen::Isometry3d drift_;
};
std::unique_ptr<support::TempFolder> MapProducts::folder_;
Eigen::Isometry3d MapProducts::drift_ = Eigen::Isometry3d::Identity();

TEST_F(MapProducts, TheSurfaceModelIsTheSceneWhereItStands) {
  const auto& scene = support::syntheticFlight().scene;
  const GeoTiffReader dsm(out("dsm.tif"));
  const GeoTiffGrid& grid = dsm.grid();
  const cv::Mat heights = dsm.heights({0, 0, grid.width, grid.height});
  std::vector<double> errors;
  int inside = 0;
  for (int row = 0; row < grid.height; ++row)
    for (int column = 0; column < grid.width; ++column) {
      const float h = heights.at<float>(row, column);
      const Eigen::Vector3d p = scenePlace(
          grid.left_m + (column + 0.5) * grid.cell_m, grid.top_m - (row + 0.5) * grid.cell_m,
          std::isnan(h) ? support::SyntheticFlight::origin().height_m : static_cast<double>(h));
      if (std::abs(scene.distanceToWall(p.x(), p.y())) < 1) continue;
      const bool well_inside = std::abs(p.x()) < 15 && std::abs(p.y()) < 12;
      inside += well_inside;
      if (!std::isnan(h) && well_inside) errors.push_back(p.z() - scene.height(p.x(), p.y()));
    }
  ASSERT_GT(inside, 1000);
  EXPECT_GT(static_cast<double>(errors.size()), 0.97 * inside);
  for (double& e : errors) e = std::abs(e);
  std::sort(errors.begin(), errors.end());
  EXPECT_LT(errors[errors.size() / 2], 0.1);
  EXPECT_LT(errors[errors.size() * 95 / 100], 0.3);
}

TEST_F(MapProducts, TheOrthophotoShowsTheSceneWhereItIs) {
  if (support::runCommand("gdal_translate --version").status != 0)
    GTEST_SKIP() << "gdal_translate is not installed";
  const auto& scene = support::syntheticFlight().scene;
  const auto info = nlohmann::json::parse(
      support::runCommand("gdalinfo -json '" + out("orthophoto.tif").string() + "'").output);
  EXPECT_EQ(info["stac"]["proj:epsg"], 32615);
  support::runCommand("gdal_translate -q -of ENVI -b 2 '" + out("orthophoto.tif").string() + "' '" +
                      out("green").string() + "'");
  const std::string green = support::fileText(out("green"));
  const int width = info["size"][0], height = info["size"][1];
  ASSERT_EQ(green.size(), static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  const double left = info["geoTransform"][0], top = info["geoTransform"][3],
               gsd = info["geoTransform"][1];
  // Correlation with the scene's own texture, shifted east and north.
  const auto agreement = [&](double shift_e, double shift_n) {
    double n = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
    for (int row = 0; row < height; row += 3)
      for (int column = 0; column < width; column += 3) {
        const Eigen::Vector3d p =
            scenePlace(left + (column + 0.5) * gsd, top - (row + 0.5) * gsd, 200);
        if (std::abs(p.x()) > 14 || std::abs(p.y()) > 11 ||
            std::abs(scene.distanceToWall(p.x(), p.y())) < 1)
          continue;
        const double x = p.x() + shift_e, y = p.y() + shift_n;
        const double truth = scene.grey({x, y, scene.height(p.x(), p.y())});
        const double seen = static_cast<std::uint8_t>(
            green[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(column)]);
        n += 1;
        a += truth;
        b += seen;
        aa += truth * truth;
        bb += seen * seen;
        ab += truth * seen;
      }
    return (ab - a * b / n) / std::sqrt((aa - a * a / n) * (bb - b * b / n));
  };
  const double here = agreement(0, 0);
  EXPECT_GT(here, 0.97);
  constexpr double kAside_m = 0.15;
  EXPECT_LT(agreement(kAside_m, 0), here);
  EXPECT_LT(agreement(-kAside_m, 0), here);
  EXPECT_LT(agreement(0, kAside_m), here);
  EXPECT_LT(agreement(0, -kAside_m), here);
}

TEST_F(MapProducts, TheLasCloudIsTheCloudAsAnIndependentReaderFinds) {
  if (support::runCommand("python3 --version").status != 0)
    GTEST_SKIP() << "python3 is not installed";
  const auto read = support::runCommand("python3 '" CF_SOURCE_DIR "/tests/formats/read_las.py' '" +
                                        out("cloud/cloud.las").string() + "' 1000");
  ASSERT_EQ(read.status, 0) << read.output.substr(0, 200);
  const auto las = nlohmann::json::parse(read.output);
  const std::vector<PlyPoint> ply = readPly(out("cloud/cloud.ply"));
  ASSERT_EQ(las["count"], ply.size());
  EXPECT_NE(las["wkt"].get<std::string>().find("32615"), std::string::npos);
  // The same points in the same order: their places differ by the worlds' origins alone.
  const auto world = nlohmann::json::parse(support::fileText(out("world.json")))["origin"];
  const LocalFrame map(world["lat"], world["lon"], world["h"]);
  for (std::size_t i = 0; i < 1000; ++i) {
    const auto& p = las["points"][i];
    const auto geodetic = utmToGeodetic({15, true}, p["xyz"][0], p["xyz"][1], p["xyz"][2]);
    EXPECT_LT((map.toEnu(geodetic.value()) - ply[i].position_m).norm(), 0.003);
    EXPECT_EQ(p["rgb"][0].get<int>(), 257 * ply[i].rgb[0]);
  }
}

TEST_F(MapProducts, LieUnderThePhotosThatTheyAreMadeOf) {
  const GeoTiffReader dsm(out("dsm.tif"));
  const GeoTiffGrid& grid = dsm.grid();
  for (const auto& uav : support::syntheticFlight().uavs)
    for (const auto& photo : uav.photos) {
      const auto utm = geodeticToUtm(
          {15, true}, {photo.fix.latitude_deg, photo.fix.longitude_deg, photo.fix.height_m});
      const int column = static_cast<int>((utm->easting_m - grid.left_m) / grid.cell_m);
      const int row = static_cast<int>((grid.top_m - utm->northing_m) / grid.cell_m);
      EXPECT_FALSE(std::isnan(dsm.heights({column, row, 1, 1}).at<float>(0, 0))) << photo.name;
    }
}

TEST_F(MapProducts, AreLeftOutWhereTheyAreNotWanted) {
  Config config = Config::fromFile(*folder_ / "in/config.ini");
  for (const char* key : {"view.snapshots=0", "densify.megapixels=0.05", "deliver.las=0",
                          "deliver.dsm=0", "deliver.orthophoto=0"})
    config.override(key);
  runFlight(config, {*folder_ / "bare", false, "1.2.3"});
  for (const char* file : {"cloud/cloud.las", "dsm.tif", "orthophoto.tif"})
    EXPECT_FALSE(fs::exists((*folder_ / "bare") / file)) << file;
  EXPECT_TRUE(fs::exists(*folder_ / "bare/cloud/cloud.ply"));
}

}  // namespace
}  // namespace cf
