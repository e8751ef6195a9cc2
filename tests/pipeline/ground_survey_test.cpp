// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// Ground points as check and as control of whole runs, with exact marks and survey.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "cf/base/error.h"
#include "cf/base/log.h"
#include "cf/config/config.h"
#include "cf/evaluate/ground_control.h"
#include "cf/formats/ply.h"
#include "cf/formats/tum.h"
#include "cf/geodesy/utm.h"
#include "cf/pipeline/flight_run.h"
#include "moved_map.h"
#include "support/synthetic_flight.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

TEST(MovedMap, PhotosSeeTheirPointsAsBefore) {
  CameraModel camera = support::distortedCamera();
  Alignment map;
  map.table.cameras = {camera};
  for (std::uint32_t i = 0; i < 2; ++i) {
    PoseTable::Entry& entry = map.table.poses[{0, i}];
    entry.T_world_cam = support::cameraAt(camera, 5.0 * i, 2, 40, 0.3, 0.1 * i, 0.05).T_world_cam;
    entry.median_depth_m = 40;
    entry.near_depth_m = 30;
    entry.far_depth_m = 50;
    for (int k = 0; k < 6; ++k) entry.covariance.in_world(k, k) = k + 1;
  }
  map.points.resize(1);
  map.points[0].position_m = {2, 1, 3};
  RelativePose between;
  between.a = {0, 0};
  between.b = {0, 1};
  const auto relative = [&] {
    return Eigen::Isometry3d(map.table.poses.at({0, 0}).T_world_cam.inverse() *
                             map.table.poses.at({0, 1}).T_world_cam);
  };
  between.T_a_b = relative();
  between.sigma << 1, 2, 3, 4, 5, 6;
  map.relative_poses = {between};
  const auto seen = [&](std::uint32_t i) {
    return camera.project(map.table.poses.at({0, i}).T_world_cam.inverse() *
                          map.points[0].position_m);
  };
  const auto middle = [&] {
    return Eigen::Vector3d((map.table.poses.at({0, 0}).T_world_cam.translation() +
                            map.table.poses.at({0, 1}).T_world_cam.translation()) /
                           2);
  };
  const Eigen::Vector3d bias(1, 2, 3), measured = middle() + bias;
  map.gnss_bias_m[0] = bias;
  const Eigen::Vector2d before[] = {seen(0), seen(1)};

  const Sim3 S{1.25,
               Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix(),
               {100, -20, 40}};
  moveMap(S, map);
  for (std::uint32_t i = 0; i < 2; ++i) EXPECT_LT((seen(i) - before[i]).norm(), 1e-9);
  EXPECT_LT((map.points[0].position_m - S * Eigen::Vector3d(2, 1, 3)).norm(), 1e-12);
  EXPECT_TRUE(map.relative_poses[0].T_a_b.isApprox(relative(), 1e-12));
  EXPECT_NEAR(map.relative_poses[0].sigma[0], 1.25, 1e-12);
  EXPECT_NEAR(map.relative_poses[0].sigma[3], 4, 1e-12);
  const PoseTable::Entry& entry = map.table.poses.at({0, 0});
  EXPECT_NEAR(entry.near_depth_m, 37.5, 1e-12);
  EXPECT_NEAR(entry.median_depth_m, 50, 1e-12);
  EXPECT_NEAR(entry.far_depth_m, 62.5, 1e-12);
  // East has become north: variances have changed places, lengths squared have grown.
  EXPECT_NEAR(entry.covariance.in_world(0, 0), 2 * 1.25 * 1.25, 1e-9);
  EXPECT_NEAR(entry.covariance.in_world(1, 1), 1 * 1.25 * 1.25, 1e-9);
  EXPECT_NEAR(entry.covariance.in_world(3, 3), 5, 1e-9);
  EXPECT_LT((map.gnss_bias_m.at(0) - (measured - middle())).norm(), 1e-9);
}

class GroundSurveyOfARun : public ::testing::Test {
 protected:
  static constexpr double kDatum_m = -40;  ///< of the list's heights against those of GNSS

  static void SetUpTestSuite() {
    setLogQuiet(true);
    folder_ = std::make_unique<support::TempFolder>();
    support::writeSyntheticFlight(*folder_ / "in");
    support::writeSyntheticFlight(*folder_ / "without_gnss", false);
  }
  static void TearDownTestSuite() { folder_.reset(); }

  /// Four places of the ground, two of the roof, and their marks by true cameras, but for one.
  static std::string exactList(const std::string& crs = "WGS84 UTM 15N", double bad_px = 0) {
    const auto& flight = support::syntheticFlight();
    const LocalFrame world(support::SyntheticFlight::origin());
    const Eigen::Vector2d places[] = {{-16, -12}, {15, -13}, {16, 12}, {-15, 13}, {5, 4}, {-4, -5}};
    std::string list = crs + "\n";
    int number = 0;
    for (const Eigen::Vector2d& xy : places) {
      const Eigen::Vector3d p(xy.x(), xy.y(), flight.scene.height(xy.x(), xy.y()));
      const Geodetic place = world.toGeodetic(p);
      const auto utm = geodeticToUtm({15, true}, place);
      ++number;
      for (const auto& uav : flight.uavs)
        for (const auto& photo : uav.photos) {
          const Eigen::Vector3d seen = photo.truth.T_world_cam.inverse() * p;
          Eigen::Vector2d pixel = photo.truth.camera.project(seen);
          if (!photo.truth.camera.contains(pixel)) continue;
          if (number == 2 && photo.name == "P10.JPG") pixel.y() += bad_px;
          list += fmt::format("{:.5f} {:.5f} {:.5f} {:.4f} {:.4f} {} p{}\n", utm->easting_m,
                              utm->northing_m, place.height_m + kDatum_m, pixel.x(), pixel.y(),
                              photo.name, number);
        }
    }
    return list;
  }

  static json run(const std::string& list, const std::string& use, const std::string& outdir,
                  const std::string& flight = "in") {
    support::writeText(*folder_ / flight / "gcp_list.txt", list);
    Config config = Config::fromFile(*folder_ / flight / "config.ini");
    for (const std::string& setting :
         {std::string("view.snapshots=0"), std::string("deliver.orthophoto=0"),
          std::string("densify.megapixels=0.05"), std::string("gcp.file=gcp_list.txt"),
          "gcp.use=" + use, std::string("world.origin=") + support::SyntheticFlight::originText()})
      config.override(setting);
    runFlight(config, {*folder_ / outdir, true, "1.2.3"});
    return json::parse(support::fileText(*folder_ / outdir / "report.json"));
  }
  template <class Error>
  static std::string errorOf(const std::string& list, const std::string& use) {
    try {
      run(list, use, "failed");
    } catch (const Error& e) {
      return e.what();
    }
    return "no such error";
  }

  /// Root mean square distance of the run's camera centres from the truth, in the list's heights.
  static double cameraError(const std::string& outdir, const Eigen::Vector3d& expected_shift) {
    const LocalFrame truth(support::SyntheticFlight::origin());
    const json origin = json::parse(support::fileText(*folder_ / outdir / "world.json"))["origin"];
    const Eigen::Isometry3d T_truth_map =
        truth.T_this_other(LocalFrame(origin["lat"], origin["lon"], origin["h"]));
    double squares = 0, count = 0;
    for (const auto& uav : support::syntheticFlight().uavs) {
      const auto poses = readTum(*folder_ / outdir / "trajectories" / (uav.name + ".tum"));
      EXPECT_EQ(poses.size(), uav.photos.size());
      for (std::size_t i = 0; i < std::min(poses.size(), uav.photos.size()); ++i, ++count)
        squares += (T_truth_map * poses[i].T_world_cam.translation() -
                    uav.photos[i].truth.T_world_cam.translation() - expected_shift)
                       .squaredNorm();
    }
    return std::sqrt(squares / count);
  }

  static bool warns(const json& report, const std::string& what) {
    return report["warnings"].dump().find(what) != std::string::npos;
  }

  static std::unique_ptr<support::TempFolder> folder_;
};
std::unique_ptr<support::TempFolder> GroundSurveyOfARun::folder_;

TEST_F(GroundSurveyOfARun, CheckPointsTellHowFarTheMapIs) {
  const std::string list = exactList("WGS84 UTM 15N", 6) +
                           "500000 5180000 0 10 10 other.jpg p1x\n"
                           "500000 5180000 0 20 20 P00.JPG p1x\n";
  const json report = run(list, "check", "check");
  const json& found = report["ground_control"];
  EXPECT_EQ(found["file"], "gcp_list.txt");
  EXPECT_EQ(found["use"], "check");
  EXPECT_EQ(found["points"], 7);
  EXPECT_EQ(found["triangulated"], 6);
  EXPECT_FALSE(found.contains("moved"));
  // Fixes of 5 cm over 22 m leave a tilt of a degree, on ground 40 m below.
  EXPECT_NEAR(found["difference_m"]["mean"][2].get<double>(), -kDatum_m, 0.1);
  EXPECT_LT(found["difference_m"]["horizontal_rms"], 1);
  EXPECT_LT(cameraError("check", {0, 0, 0}), 0.3);
  EXPECT_TRUE(warns(report, "1 of its photos are not of this flight (other.jpg)"));
  EXPECT_TRUE(warns(report, "the marks of ground point p2 disagree, worst in P10.JPG by "));
  EXPECT_EQ(report["warnings"].dump().find("disagree"),
            report["warnings"].dump().rfind("disagree"));
  EXPECT_TRUE(warns(report, "p1x is left out: marked in 1 photo with a pose, two are needed"));
  EXPECT_NE(found["missing"]["p1x"].get<std::string>().find("two are needed"), std::string::npos);
  EXPECT_NE(support::fileText(*folder_ / "check/report.html").find("Ground check points"),
            std::string::npos);

  // cf-eval finds the same in the run's files.
  const json again =
      json::parse(evaluateGroundControl(*folder_ / "check", *folder_ / "in" / "gcp_list.txt", {}));
  ASSERT_EQ(again["per_point"].size(), found["per_point"].size());
  for (std::size_t i = 0; i < found["per_point"].size(); ++i) {
    const json &a = found["per_point"][i], &b = again["per_point"][i];
    EXPECT_EQ(a["name"], b["name"]);
    EXPECT_EQ(a["marks"], b["marks"]);
    EXPECT_GT(a["marks"], 3);
    EXPECT_NEAR(a["rms_px"].get<double>(), b["rms_px"].get<double>(), 1e-3);
    EXPECT_EQ(a["max_px"] < 1.0, a["name"] != "p2") << a["name"];
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_NEAR(a["difference_m"][k].get<double>(), b["difference_m"][k].get<double>(), 1e-3);
  }
}

TEST_F(GroundSurveyOfARun, ControlPointsBringTheMapToTheirDatum) {
  const json report = run(exactList(), "control", "control");
  const json& found = report["ground_control"];
  EXPECT_EQ(found["use"], "control");
  EXPECT_EQ(found["triangulated"], 6);
  EXPECT_LT(found["difference_m"]["rms"], 0.03);
  EXPECT_LT(found["left_out_difference_m"]["rms"], 0.08);
  EXPECT_GT(found["left_out_difference_m"]["rms"], found["difference_m"]["rms"]);
  EXPECT_NEAR(found["moved"]["shift_m"][2].get<double>(), kDatum_m, 0.1);
  EXPECT_NEAR(found["moved"]["scale"].get<double>(), 1, 0.005);
  EXPECT_LT(cameraError("control", {0, 0, kDatum_m}), 0.06);
  for (const auto& uav : support::syntheticFlight().uavs)
    EXPECT_NEAR(report["uavs"][uav.name]["gnss_bias_m"][2].get<double>(), -kDatum_m, 0.2);
  EXPECT_EQ(json::parse(support::fileText(*folder_ / "control/world.json"))["h_datum"], "unknown")
      << "what the list's heights count from, it does not say";
  // The dense map has gone with it.
  std::vector<double> errors;
  for (const PlyPoint& p : readPly(*folder_ / "control/cloud/cloud.ply")) {
    const auto& scene = support::syntheticFlight().scene;
    const double x = p.position_m.x(), y = p.position_m.y();
    if (std::abs(scene.distanceToWall(x, y)) < 1 || std::max(std::abs(x), std::abs(y)) > 15)
      continue;
    errors.push_back(std::abs(p.position_m.z() - scene.height(x, y) - kDatum_m));
  }
  ASSERT_GT(errors.size(), 5000u);
  std::nth_element(errors.begin(), errors.begin() + static_cast<long>(errors.size() / 2),
                   errors.end());
  EXPECT_LT(errors[errors.size() / 2], 0.1);
}

TEST_F(GroundSurveyOfARun, ControlGivesARelativeMapItsPlace) {
  const std::string list = exactList();
  const json report = run(list, "control", "placed", "without_gnss");
  EXPECT_LT(report["ground_control"]["difference_m"]["rms"], 0.05);
  EXPECT_LT(cameraError("placed", {0, 0, kDatum_m}), 0.15);
  EXPECT_FALSE(warns(report, "relative"));
  EXPECT_FALSE(warns(report, "disagree"));
  EXPECT_TRUE(fs::exists(*folder_ / "placed/shots.geojson"));
  EXPECT_EQ(json::parse(support::fileText(*folder_ / "placed/world.json"))["utm"], "15N");
}

TEST_F(GroundSurveyOfARun, ListsThatCannotBeUsedAreRefusedAtOnce) {
  EXPECT_NE(errorOf<UsageError>(exactList("EPSG:3857"), "check").find("EPSG:3857"),
            std::string::npos);
  const std::string theirs = "WGS84 UTM 15N\n500000 5180000 0 1 2 a.jpg\n";
  EXPECT_NE(errorOf<UsageError>(theirs, "check").find("none of its photos (a.jpg, …)"),
            std::string::npos);
  EXPECT_NE(errorOf<RunError>("WGS84 UTM 15N\n1e6 5e6 0 700 2 P00.JPG p\n", "check")
                .find("ground point p is marked at 700, 2 in P00.JPG, a photo of 640x480"),
            std::string::npos);
  std::string row = "WGS84 UTM 15N\n";
  for (int i = 0; i < 5; ++i)
    row += fmt::format("{} {} 0 1 2 P00.JPG p{}\n", 500000 + 20 * i, 5180000 + i % 2, i);
  EXPECT_NE(errorOf<UsageError>(row, "control").find("almost on one line"), std::string::npos);
  EXPECT_FALSE(fs::exists(*folder_ / "failed")) << "before anything is made";
}

TEST_F(GroundSurveyOfARun, ControlWithTooFewPointsInSightIsRefused) {
  const std::string list =
      "WGS84 UTM 15N\n500000 5180000 0 5 5 P01.JPG a\n500900 5180000 0 5 5 P01.JPG b\n"
      "500000 5180900 0 5 5 P01.JPG c\n";
  const std::string error = errorOf<RunError>(list, "control");
  EXPECT_NE(error.find("0 of 3 ground points could be triangulated"), std::string::npos) << error;
}

}  // namespace
}  // namespace cf
