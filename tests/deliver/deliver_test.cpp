// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/deliver/deliver.h"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "cf/base/error.h"
#include "cf/deliver/hand_over.h"
#include "cf/formats/csv.h"
#include "cf/formats/ply.h"
#include "cf/formats/pose_covariance_csv.h"
#include "cf/formats/tum.h"
#include "cf/geodesy/local_frame.h"
#include "delivered_run.h"

namespace cf {
namespace {

TEST_F(Deliver, EveryFileOfTheContractIsThere) {
  deliver(makeRun(), dir_);
  for (const char* file : {"report.json",
                           "report.html",
                           "world.json",
                           "images/east.csv",
                           "trajectories/east.tum",
                           "trajectories/east.online.tum",
                           "trajectories/east.ecef.csv",
                           "trajectories/east.covariance.csv",
                           "trajectories/all.geojson",
                           "trajectories/all.kml",
                           "cameras/east.ini",
                           "scale/east.csv",
                           "graphs/east.graph",
                           "relative_poses.csv",
                           "cloud/sparse.ply",
                           "odometry/east.tum",
                           "colmap/cameras.txt",
                           "colmap/images.txt",
                           "colmap/points3D.txt",
                           "colmap/origin.txt",
                           "shots.geojson",
                           "map.kml"})
    EXPECT_TRUE(fs::is_regular_file(dir_ / file)) << file;
  for (const auto& entry : fs::recursive_directory_iterator(dir_))
    EXPECT_NE(entry.path().extension(), ".tmp") << entry.path();
}

TEST_F(Deliver, ThePageIsLeftOutWhereItIsNotWanted) {
  DeliverOptions options;
  options.html = false;
  deliver(makeRun(), dir_, options);
  EXPECT_TRUE(fs::exists(dir_ / "report.json"));
  EXPECT_FALSE(fs::exists(dir_ / "report.html"));
}

TEST_F(Deliver, CsvHeadersAreExact) {
  deliver(makeRun(), dir_);
  EXPECT_EQ(firstLine(dir_ / "images/east.csv"),
            "image,t,status,segment,keypoints,matches,inliers,reason");
  EXPECT_EQ(firstLine(dir_ / "trajectories/east.ecef.csv"), "image,t,x,y,z");
  EXPECT_EQ(firstLine(dir_ / "scale/east.csv"), "t,segment,scale,sigma");
  EXPECT_EQ(firstLine(dir_ / "relative_poses.csv"),
            "uav_a,uav_b,image_a,image_b,inliers,tx,ty,tz,qx,qy,qz,qw,sigma_tx,sigma_ty,sigma_tz,"
            "sigma_rx,sigma_ry,sigma_rz,residual_before,residual_after");
}

TEST_F(Deliver, ImagesKeepStatusReasonAndTime) {
  const RunRecord run = makeRun();
  writeImagesCsv(run, dir_);
  const CsvTable table(dir_ / "images/east.csv");
  ASSERT_EQ(table.rows().size(), 4U);
  EXPECT_EQ(table.rows()[1], (CsvRow{"DJI_0001.JPG", "1466699520.123456789", "posed", "0", "2001",
                                     "501", "301", ""}));
  EXPECT_EQ(table.rows()[2][2], "damaged");
  EXPECT_EQ(table.rows()[2][3], "");
  EXPECT_EQ(table.rows()[2][7], run.uavs[0].photos[2].reason);
}

TEST_F(Deliver, TrajectoriesJoinWithTheImagesByTheTextOfTheTime) {
  const RunRecord run = makeRun();
  writeImagesCsv(run, dir_);
  writeTrajectories(run, dir_);
  std::set<std::string> posed;
  const CsvTable images(dir_ / "images/east.csv");
  for (const auto& row : images.rows())
    if (row[2] == "posed") posed.insert(row[1]);
  std::set<std::string> in_tum;
  std::istringstream lines(textOf(dir_ / "trajectories/east.tum"));
  for (std::string line; std::getline(lines, line);)
    if (line.front() != '#') in_tum.insert(line.substr(0, line.find(' ')));
  EXPECT_EQ(posed, in_tum);

  const auto poses = readTum(dir_ / "trajectories/east.tum");
  const auto online = readTum(dir_ / "trajectories/east.online.tum");
  ASSERT_EQ(poses.size(), 3U);
  ASSERT_EQ(online.size(), 3U);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_TRUE(poses[i].T_world_cam.isApprox(run.uavs[0].final_trajectory[i].T_world_cam, 1e-7));
    EXPECT_TRUE(online[i].T_world_cam.isApprox(run.uavs[0].online_trajectory[i].T_world_cam, 1e-7));
  }
}

TEST_F(Deliver, CovariancesComeBack) {
  RunRecord run = makeRun();
  PhotoCovariance& known = run.uavs[0].covariances[1];
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) {
      known.covariance.in_world(i, j) = 1 / (1.0 + i + j);
      known.covariance.in_map(i, j) = i == j ? 0.01 : 1e-4 * (i + j);
    }
  known.component = 2;
  writeCovariances(run, dir_);
  const fs::path file = dir_ / "trajectories/east.covariance.csv";
  EXPECT_EQ(firstLine(file).substr(0, 66),
            "image,t,component,world_tx_tx,world_tx_ty,world_tx_tz,world_tx_rx,");
  const auto rows = readPoseCovariances(file);
  ASSERT_EQ(rows.size(), 1U) << "only where it is known";
  EXPECT_EQ(rows[0].image, "DJI_0001.JPG");
  EXPECT_EQ(rows[0].time, run.uavs[0].photos[1].time);
  EXPECT_EQ(rows[0].component, 2);
  EXPECT_TRUE(rows[0].covariance.in_world.isApprox(known.covariance.in_world, 1e-8));
  EXPECT_TRUE(rows[0].covariance.in_map.isApprox(known.covariance.in_map, 1e-8));
}

// WGS84 by the textbook formulas, independent of libs/geodesy.
Eigen::Vector3d ecefByHand(double lat_deg, double lon_deg, double h) {
  const double a = 6378137.0, f = 1 / 298.257223563, e2 = f * (2 - f);
  const double lat = lat_deg * M_PI / 180, lon = lon_deg * M_PI / 180;
  const double n = a / std::sqrt(1 - e2 * std::sin(lat) * std::sin(lat));
  return {(n + h) * std::cos(lat) * std::cos(lon), (n + h) * std::cos(lat) * std::sin(lon),
          (n * (1 - e2) + h) * std::sin(lat)};
}

TEST_F(Deliver, EcefIsTheEastNorthUpOfTheOriginTurned) {
  const RunRecord run = makeRun();
  writeTrajectories(run, dir_);
  const CsvTable table(dir_ / "trajectories/east.ecef.csv");
  ASSERT_EQ(table.rows().size(), 3U);
  const double lat = run.world.latitude_deg * M_PI / 180;
  const double lon = run.world.longitude_deg * M_PI / 180;
  const Eigen::Vector3d east(-std::sin(lon), std::cos(lon), 0);
  const Eigen::Vector3d up(std::cos(lat) * std::cos(lon), std::cos(lat) * std::sin(lon),
                           std::sin(lat));
  const Eigen::Vector3d north = up.cross(east);
  const Eigen::Vector3d origin =
      ecefByHand(run.world.latitude_deg, run.world.longitude_deg, run.world.height_m);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& row = table.rows()[i];
    const Eigen::Vector3d p = run.uavs[0].final_trajectory[i].T_world_cam.translation();
    const Eigen::Vector3d expected = origin + p.x() * east + p.y() * north + p.z() * up;
    const Eigen::Vector3d written(std::stod(row[2]), std::stod(row[3]), std::stod(row[4]));
    EXPECT_LT((written - expected).norm(), 2e-4);
  }
  EXPECT_EQ(table.rows()[2][0], "DJI_0003.JPG");
}

TEST_F(Deliver, GeojsonHoldsALineForEachUavAndAPointForEachPhoto) {
  const RunRecord run = makeRun();
  writeGeojson(run, dir_);
  const auto json = nlohmann::json::parse(textOf(dir_ / "trajectories/all.geojson"));
  EXPECT_EQ(json["type"], "FeatureCollection");
  int lines = 0, points = 0;
  for (const auto& feature : json["features"]) {
    const auto& geometry = feature["geometry"];
    if (geometry["type"] == "LineString") {
      ++lines;
      ASSERT_EQ(geometry["coordinates"].size(), 3U);
      if (feature["properties"]["uav"] != "east") continue;
      const auto& c = geometry["coordinates"][1];
      const Eigen::Vector3d here = ecefByHand(c[1], c[0], c[2]);
      const LocalFrame frame(run.world.latitude_deg, run.world.longitude_deg, run.world.height_m);
      const Eigen::Vector3d there =
          frame.toEcef(run.uavs[0].final_trajectory[1].T_world_cam.translation());
      EXPECT_LT((here - there).norm(), 1e-3);
    } else {
      ++points;
    }
  }
  EXPECT_EQ(lines, 2);
  EXPECT_EQ(points, 6);
}

TEST_F(Deliver, KmlIsWellFormedWithAnyUavName) {
  writeKml(makeRun(), dir_);
  const std::string kml = textOf(dir_ / "trajectories/all.kml");
  EXPECT_TRUE(wellFormed(kml));
  EXPECT_NE(kml.find("west &amp; &lt;2&gt;"), std::string::npos);
  // Longitude before latitude.
  EXPECT_NE(kml.find("-91.9945"), std::string::npos);
  EXPECT_LT(kml.find("-91.9945"), kml.find(",46.84"));
}

TEST_F(Deliver, TheMapKmlIsWellFormedWithAnyPhotoName) {
  RunRecord run = makeRun();
  run.uavs[0].photos[0].name = "B\xC3\xA4ume <1>\x01.JPG";
  run.uavs[0].photos[1].name = "B\xE4ume.JPG";  // Latin-1
  writeMapKml(run, dir_);
  const std::string kml = textOf(dir_ / "map.kml");
  EXPECT_TRUE(wellFormed(kml));
  EXPECT_NE(kml.find("B\xC3\xA4ume &lt;1&gt;?.JPG"), std::string::npos);
  EXPECT_NE(kml.find("B?ume.JPG"), std::string::npos);
  EXPECT_EQ(kml.find("outline of"), std::string::npos) << "one point has none";
}

TEST_F(Deliver, AThirdRadialTermNeedsColmapsFullModel) {
  RunRecord run = makeRun();
  run.uavs[1].camera_after.k3 = 0.0125;
  writeColmapModel(run, dir_);
  const std::string cameras = textOf(dir_ / "colmap/cameras.txt");
  EXPECT_NE(cameras.find("\n1 OPENCV 4000 3000 2345.678901 2345.678901 2000 1500 -0.0123456789 0 0 "
                         "0\n"),
            std::string::npos)
      << cameras;
  EXPECT_NE(cameras.find("\n2 FULL_OPENCV 4000 3000 "), std::string::npos) << cameras;
  EXPECT_NE(cameras.find(" 0.0125 0 0 0\n"), std::string::npos) << cameras;
}

TEST_F(Deliver, NothingIsHandedOverWhereItIsNotWanted) {
  DeliverOptions options;
  options.handover = false;
  deliver(makeRun(), dir_, options);
  for (const char* file : {"colmap", "shots.geojson", "map.kml"})
    EXPECT_FALSE(fs::exists(dir_ / file)) << file;
}

TEST_F(Deliver, RelativePosesKeepTheirNumbers) {
  const RunRecord run = makeRun();
  writeRelativePoses(run, dir_);
  const CsvTable table(dir_ / "relative_poses.csv");
  ASSERT_EQ(table.rows().size(), 1U);
  const auto& row = table.rows()[0];
  EXPECT_EQ(row[0], "east");
  EXPECT_EQ(row[1], "west & <2>");
  EXPECT_EQ(row[2], "DJI_0001.JPG");
  EXPECT_EQ(row[3], "DJI_0003.JPG");
  EXPECT_EQ(row[4], "77");
  const auto at = [&](const char* column) { return std::stod(row[table.column(column)]); };
  EXPECT_NEAR(at("ty"), -2.5, 1e-9);
  const Eigen::Quaterniond q(at("qw"), at("qx"), at("qy"), at("qz"));
  EXPECT_LT(q.angularDistance(Eigen::Quaterniond(run.relative_poses[0].T_a_b.linear())), 1e-7);
  EXPECT_NEAR(at("sigma_tz"), 0.3, 1e-9);
  EXPECT_NEAR(at("sigma_rx"), 0.01, 1e-9);
  EXPECT_NEAR(at("residual_before"), 2.5, 1e-9);
  EXPECT_NEAR(at("residual_after"), 0.05, 1e-9);
}

TEST_F(Deliver, CamerasHoldBothCalibrations) {
  writeCameras(makeRun(), dir_);
  const std::string ini = textOf(dir_ / "cameras/east.ini");
  const auto camera = ini.find("[camera]"), before = ini.find("[before]");
  ASSERT_NE(camera, std::string::npos);
  ASSERT_NE(before, std::string::npos);
  EXPECT_LT(ini.find("fx = 2345.678901"), before);
  EXPECT_LT(ini.find("k1 = -0.0123456789"), before);
  EXPECT_LT(ini.find("focal_sigma = 3.5"), before);
  EXPECT_GT(ini.find("fx = 2300.25"), before);
  EXPECT_GT(ini.find("focal_sigma = 115"), before);
}

TEST_F(Deliver, WorldAndSparsePoints) {
  const RunRecord run = makeRun();
  writeWorldJson(run, dir_);
  const auto world = nlohmann::json::parse(textOf(dir_ / "world.json"));
  EXPECT_EQ(world["origin"]["lat"], run.world.latitude_deg);
  EXPECT_EQ(world["origin"]["lon"], run.world.longitude_deg);
  EXPECT_EQ(world["origin"]["h"], run.world.height_m);
  EXPECT_EQ(world["h_datum"], "ellipsoid");
  EXPECT_EQ(world["frame"], "ENU");
  EXPECT_EQ(world["utm"], "15N");
  EXPECT_EQ(world["center"], "east");
  writeSparsePly(run, dir_);
  const auto points = readPly(dir_ / "cloud/sparse.ply");
  ASSERT_EQ(points.size(), 1U);
  EXPECT_EQ(points[0].position_m, Eigen::Vector3d(1.5, 2.5, -60));
  EXPECT_EQ(points[0].rgb, (std::array<std::uint8_t, 3>{30, 20, 10}));
}

TEST_F(Deliver, ARelativeMapSaysSoAndHasNoGeographicFiles) {
  RunRecord run = makeRun();
  run.world.relative = true;
  deliver(run, dir_);
  for (const char* file : {"trajectories/all.geojson", "trajectories/all.kml",
                           "trajectories/east.ecef.csv", "shots.geojson", "map.kml"})
    EXPECT_FALSE(fs::exists(dir_ / file)) << file;
  EXPECT_NE(textOf(dir_ / "colmap/origin.txt").find("relative"), std::string::npos);
  EXPECT_TRUE(fs::exists(dir_ / "trajectories/east.tum"));
  const auto world = nlohmann::json::parse(textOf(dir_ / "world.json"));
  EXPECT_TRUE(world["origin"].is_null());
  EXPECT_EQ(world["frame"], "local");
  const auto report = nlohmann::json::parse(textOf(dir_ / "report.json"));
  ASSERT_EQ(report["warnings"].size(), 2U);
  EXPECT_NE(report["warnings"][1].get<std::string>().find("relative"), std::string::npos);
}

TEST_F(Deliver, AFolderThatCannotBeMadeIsNamed) {
  std::ofstream(dir_) << "in the way";
  try {
    deliver(makeRun(), dir_);
    FAIL();
  } catch (const RunError& e) {
    EXPECT_NE(std::string(e.what()).find(dir_.string()), std::string::npos);
  }
}

}  // namespace
}  // namespace cf
