// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// Every file that a run promises is there, and reads as promised.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "cf/base/log.h"
#include "cf/config/config.h"
#include "cf/formats/csv.h"
#include "cf/formats/ply.h"
#include "cf/formats/pose_covariance_csv.h"
#include "cf/formats/tile_store.h"
#include "cf/formats/tum.h"
#include "cf/pipeline/flight_run.h"
#include "support/synthetic_flight.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// One run for all tests; one photo of the second UAV breaks off.
class OutputContract : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    setLogQuiet(true);
    folder_ = std::make_unique<support::TempFolder>();
    const fs::path ini = support::writeSyntheticFlight(*folder_ / "in");
    auto half = support::syntheticFlight().uavs[1].photos[4].jpeg;
    half.resize(half.size() / 2);
    support::writeBytes(*folder_ / "in/northB_Images/P14.JPG", half);
    Config config = Config::fromFile(ini);
    config.override("view.size=320x240");
    config.override("densify.megapixels=0.1");
    runFlight(config, {out(""), false, "1.2.3"});
  }
  static void TearDownTestSuite() { folder_.reset(); }
  static fs::path out(const std::string& file) { return *folder_ / "out" / file; }
  static json parsed(const std::string& file) { return json::parse(support::fileText(out(file))); }
  static std::string firstLine(const std::string& file) {
    std::ifstream in(out(file));
    std::string line;
    std::getline(in, line);
    return line;
  }
  static std::unique_ptr<support::TempFolder> folder_;
};
std::unique_ptr<support::TempFolder> OutputContract::folder_;

TEST_F(OutputContract, EveryFileIsThere) {
  std::vector<std::string> files = {"report.json",
                                    "report.html",
                                    "config.effective.ini",
                                    "world.json",
                                    "cloud/cloud.ply",
                                    "cloud/tiles.json",
                                    "trajectories/all.geojson",
                                    "trajectories/all.kml",
                                    "cloud/sparse.ply",
                                    "octomap.ot",
                                    "octomap.bt",
                                    "relative_poses.csv",
                                    "map.3Dscene",
                                    "map.kml",
                                    "shots.geojson",
                                    "colmap/cameras.txt",
                                    "colmap/images.txt",
                                    "colmap/points3D.txt",
                                    "colmap/origin.txt"};
  for (const auto& [name, photos] : support::syntheticFlight().uavs)
    for (const std::string& file :
         {"images/" + name + ".csv", "trajectories/" + name + ".tum",
          "trajectories/" + name + ".online.tum", "trajectories/" + name + ".ecef.csv",
          "trajectories/" + name + ".covariance.csv", "cameras/" + name + ".ini",
          "scale/" + name + ".csv", "graphs/" + name + ".graph", "odometry/" + name + ".tum"})
      files.push_back(file);
  for (const std::string& file : files) {
    ASSERT_TRUE(fs::exists(out(file))) << file;
    EXPECT_GT(fs::file_size(out(file)), 0u) << file;
  }
  EXPECT_FALSE(fs::is_empty(out("snapshots")));
  EXPECT_FALSE(fs::exists(out("work"))) << "left from the making";
  for (const auto& item : fs::recursive_directory_iterator(out("")))
    EXPECT_NE(item.path().extension(), ".tmp") << item.path();
}

TEST_F(OutputContract, ImagesAndTrajectoriesGoTogether) {
  for (const auto& uav : support::syntheticFlight().uavs) {
    const std::string csv = "images/" + uav.name + ".csv";
    EXPECT_EQ(firstLine(csv), "image,t,status,segment,keypoints,matches,inliers,reason");
    const CsvTable images(out(csv));
    ASSERT_EQ(images.rows().size(), uav.photos.size());
    std::vector<std::string> posed;
    for (std::size_t i = 0; i < uav.photos.size(); ++i) {
      const CsvRow& row = images.rows()[i];
      EXPECT_EQ(row[0], uav.photos[i].name);
      const bool damaged = uav.photos[i].name == "P14.JPG";
      EXPECT_EQ(row[2], damaged ? "damaged" : "posed") << row[0];
      EXPECT_EQ(row[7].empty(), !damaged) << row[0] << ": " << row[7];
      EXPECT_EQ(timeFromText(row[1]), uav.photos[i].time);
      if (!damaged) posed.push_back(row[1]);
    }
    std::ifstream tum(out("trajectories/" + uav.name + ".tum"));
    std::vector<std::string> times;
    for (std::string line; std::getline(tum, line);)
      times.push_back(line.substr(0, line.find(' ')));
    EXPECT_EQ(times, posed) << "the same decimal text";
    // The first photos have no place in the world until scale and heading are known.
    const std::size_t online = readTum(out("trajectories/" + uav.name + ".online.tum")).size();
    EXPECT_GE(online, 2u);
    EXPECT_LE(online, posed.size());

    EXPECT_EQ(firstLine("trajectories/" + uav.name + ".ecef.csv"), "image,t,x,y,z");
    EXPECT_EQ(CsvTable(out("trajectories/" + uav.name + ".ecef.csv")).rows().size(), posed.size());
    EXPECT_EQ(readPoseCovariances(out("trajectories/" + uav.name + ".covariance.csv")).size(),
              posed.size());
    EXPECT_EQ(firstLine("scale/" + uav.name + ".csv").substr(0, 21), "t,segment,scale,sigma");
  }
}

TEST_F(OutputContract, ReportAndWorld) {
  const json report = parsed("report.json");
  EXPECT_EQ(report["version"], "1.2.3");
  EXPECT_GT(report["wall_s"], 0);
  EXPECT_GT(report["peak_rss_mb"], 0);
  EXPECT_EQ(report["photos"]["total"], 15);
  EXPECT_EQ(report["photos"]["posed"], 14);
  EXPECT_EQ(report["components"], 1);
  EXPECT_GT(report["bytes_over_seam"], 0);
  for (const char* stage : {"decode", "odometry", "georeference", "align", "densify", "fuse"})
    for (const char* key : {"wall_s", "cpu_s"})
      EXPECT_TRUE(report["stages"][stage][key].is_number()) << stage << key;
  for (const char* key : {"p50", "p95", "max"}) EXPECT_GT(report["latency_s"][key], 0) << key;
  ASSERT_EQ(report["uavs"].size(), 3u);
  for (const auto& [name, uav] : report["uavs"].items()) {
    for (const char* key : {"photos", "posed", "segments", "scale", "scale_sigma"})
      EXPECT_TRUE(uav[key].is_number()) << name << key;
    for (const char* key : {"gnss_sigma_m", "gnss_bias_m"}) EXPECT_EQ(uav[key].size(), 3u) << key;
    EXPECT_EQ(uav["gnss_trusted"], true) << name;
  }
  EXPECT_TRUE(report["warnings"].is_array());

  const json world = parsed("world.json");
  const GnssFix& first = support::syntheticFlight().uavs[0].photos[0].fix;
  EXPECT_NEAR(world["origin"]["lat"].get<double>(), first.latitude_deg, 1e-9);
  EXPECT_NEAR(world["origin"]["lon"].get<double>(), first.longitude_deg, 1e-9);
  EXPECT_NEAR(world["origin"]["h"].get<double>(), first.height_m, 1e-3);
  EXPECT_EQ(world["h_datum"], "ellipsoid");
  EXPECT_EQ(world["frame"], "ENU");
  EXPECT_EQ(world["utm"], "15N");
  EXPECT_EQ(world["center"], "northA");
  EXPECT_EQ(parsed("trajectories/all.geojson")["type"], "FeatureCollection");
}

TEST_F(OutputContract, CloudAndTilesHoldTheSamePoints) {
  const std::string head = support::fileText(out("cloud/cloud.ply")).substr(0, 400);
  EXPECT_EQ(head.find("ply\nformat binary_little_endian 1.0\n"), 0u);
  EXPECT_NE(head.find("property float x\nproperty float y\nproperty float z\nproperty uchar red\n"
                      "property uchar green\nproperty uchar blue\nend_header\n"),
            std::string::npos);
  const std::size_t points = readPly(out("cloud/cloud.ply")).size();
  EXPECT_GT(points, 50'000u);
  EXPECT_GT(readPly(out("cloud/sparse.ply")).size(), 500u);
  std::size_t in_tiles = 0;
  const json tiles = parsed("cloud/tiles.json");
  for (const auto& tile : tiles["tiles"]) in_tiles += tile["points"].get<std::size_t>();
  EXPECT_EQ(in_tiles, points);
}

}  // namespace
}  // namespace cf
