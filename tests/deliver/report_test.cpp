// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// What report.json and report.html say of a run.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "cf/deliver/deliver.h"
#include "delivered_run.h"

namespace cf {
namespace {

TEST_F(Deliver, ReportHoldsWhatTheContractNames) {
  RunRecord run = makeRun();
  run.uavs[1].gnss.sigma_m.z() = std::numeric_limits<double>::quiet_NaN();
  run.uavs[1].scale_history.clear();
  writeReportJson(run, dir_);
  const auto report = nlohmann::json::parse(textOf(dir_ / "report.json"));
  EXPECT_EQ(report["version"], "0.1.0");
  EXPECT_EQ(report["wall_s"], 12.5);
  EXPECT_EQ(report["peak_rss_mb"], 800);
  EXPECT_EQ(report["photos"]["total"], 8);
  EXPECT_EQ(report["photos"]["posed"], 6);
  EXPECT_EQ(report["components"], 1);
  EXPECT_EQ(report["bytes_over_seam"], 123456789012);
  EXPECT_EQ(report["stages"]["odometry"]["wall_s"], 4.0);
  EXPECT_EQ(report["stages"]["odometry"]["cpu_s"], 8.0);
  EXPECT_NEAR(report["latency_s"]["p50"].get<double>(), 0.50, 1e-12);
  EXPECT_NEAR(report["latency_s"]["p95"].get<double>(), 0.95, 1e-12);
  EXPECT_NEAR(report["latency_s"]["max"].get<double>(), 1.00, 1e-12);
  const auto& uav = report["uavs"]["east"];
  EXPECT_EQ(uav["photos"], 4);
  EXPECT_EQ(uav["posed"], 3);
  EXPECT_EQ(uav["segments"], 1);
  EXPECT_EQ(uav["scale"], 12.5);
  EXPECT_EQ(uav["scale_sigma"], 0.25);
  EXPECT_EQ(uav["gnss_sigma_m"], (nlohmann::json{0.5, 0.6, 1.5}));
  EXPECT_EQ(uav["gnss_bias_m"], (nlohmann::json{0.1, -0.2, 3.0}));
  EXPECT_EQ(uav["gnss_trusted"], true);
  EXPECT_TRUE(report["uavs"]["west & <2>"]["scale"].is_null());
  EXPECT_TRUE(report["uavs"]["west & <2>"]["gnss_sigma_m"][2].is_null());
  EXPECT_EQ(report["warnings"], (nlohmann::json::array({"a warning with <angle> brackets"})));
}

TEST_F(Deliver, GroundPointsAreInBothReports) {
  RunRecord run = makeRun();
  GroundControlRecord& ground = run.ground_control.emplace();
  ground.file = "gcp_list.txt";
  ground.missing["far"] = "the rays are parallel";
  writeReportJson(run, dir_);
  auto found = nlohmann::json::parse(textOf(dir_ / "report.json"))["ground_control"];
  EXPECT_EQ(found["points"], 1);
  EXPECT_EQ(found["triangulated"], 0);
  EXPECT_TRUE(found["difference_m"].is_null());
  EXPECT_EQ(found["missing"]["far"], "the rays are parallel");

  GroundPointRecord point;
  point.name = "<a>";
  point.marks = 4;
  point.rms_px = 0.5;
  point.difference_m = {3, 4, 12};
  ground.points.push_back(point);
  point.difference_m = {3, 4, -12};
  point.left_out_m = Eigen::Vector3d(0, 0, 2);
  ground.points.push_back(point);
  ground.moved = MapMotion{{1, 2, 40}, 0.25, 1.01};
  writeReportJson(run, dir_);
  found = nlohmann::json::parse(textOf(dir_ / "report.json"))["ground_control"];
  EXPECT_EQ(found["use"], "control");
  EXPECT_NEAR(found["difference_m"]["rms"].get<double>(), 13, 1e-12);
  EXPECT_NEAR(found["difference_m"]["horizontal_rms"].get<double>(), 5, 1e-12);
  EXPECT_NEAR(found["difference_m"]["vertical_rms"].get<double>(), 12, 1e-12);
  EXPECT_EQ(found["difference_m"]["mean"], (nlohmann::json{3.0, 4.0, 0.0}));
  EXPECT_EQ(found["left_out_difference_m"]["vertical_rms"], 2.0);
  EXPECT_EQ(found["moved"]["shift_m"], (nlohmann::json{1.0, 2.0, 40.0}));
  EXPECT_EQ(found["per_point"][1]["left_out_difference_m"], (nlohmann::json{0.0, 0.0, 2.0}));
  writeReportHtml(run, dir_);
  const std::string html = textOf(dir_ / "report.html");
  EXPECT_TRUE(wellFormed(html, {"meta", "img"}));
  EXPECT_NE(html.find("&lt;a&gt;"), std::string::npos);
  EXPECT_NE(html.find("2 of 3 triangulated; RMS 5.000 m horizontally, 12.000 m vertically"),
            std::string::npos);
}

TEST_F(Deliver, ReportPageIsSelfContainedAndWellFormed) {
  writeReportHtml(makeRun(), dir_);
  const std::string html = textOf(dir_ / "report.html");
  EXPECT_TRUE(wellFormed(html, {"meta", "img"}));
  EXPECT_EQ(html.find("src=\"http"), std::string::npos);
  EXPECT_NE(html.find("a warning with &lt;angle&gt; brackets"), std::string::npos);
  EXPECT_NE(html.find("DJI_0002.JPG"), std::string::npos);  // lost, with its reason
  EXPECT_NE(html.find("premature end"), std::string::npos);
  EXPECT_NE(html.find("<svg"), std::string::npos);
}

TEST_F(Deliver, HeightsOfUnknownDatumAreSaid) {
  RunRecord run = makeRun();
  run.world.h_datum = HeightDatum::kUnknown;
  EXPECT_EQ(allWarnings(run).size(), 2U);
  run.world.h_datum = HeightDatum::kEllipsoid;
  EXPECT_EQ(allWarnings(run).size(), 1U);
}

}  // namespace
}  // namespace cf
