// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// A run that is exact, and runs with one known fault each: just the figures of that fault move.
#include "cf/evaluate/run.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "cf/base/error.h"
#include "evaluate/simulated_run.h"

namespace cf {
namespace {

using nlohmann::json;
using support::Faults;
using support::SimulatedRun;

json figuresOf(const Faults& faults) {
  const SimulatedRun run(faults);
  return json::parse(evaluateRun(run.out(), run.truth()));
}

double at(const json& figures, const char* pointer) {
  const json value = figures.at(json::json_pointer(pointer));
  return value.is_number() ? value.get<double>() : std::nan("");
}

/// Figures that a fault may move, all but nothing where there is none.
constexpr const char* kErrors[] = {"/trajectory/se3/rmse_m",
                                   "/trajectory/sim3/rmse_m",
                                   "/trajectory/sim3/rotation_rmse_deg",
                                   "/uav_pairs/rotation_rms_deg",
                                   "/uav_pairs/translation_rms_m",
                                   "/relative_poses/rotation_deg/rms",
                                   "/relative_poses/direction_deg/rms",
                                   "/seam/all/horizontal_m/p95",
                                   "/seam/all/vertical_m/p95",
                                   "/ground/all/horizontal_m/p95",
                                   "/ground/all/vertical_m/p95",
                                   "/doming/span_m",
                                   "/depth/as_is/m/p95",
                                   "/depth/scaled/m/p95",
                                   "/cloud/height/m/p95",
                                   "/cloud/flying/share",
                                   "/camera/focal_rms_pct",
                                   "/gnss/relative_bias_rms_m/horizontal",
                                   "/scale/error_end_pct/max"};

/// All of them but those that begin as one of `moved` are nothing.
void expectNoOtherError(const json& figures, const std::vector<std::string>& moved) {
  for (const std::string pointer : kErrors) {
    bool may_move = false;
    for (const std::string& m : moved) may_move = may_move || pointer.rfind(m, 0) == 0;
    if (may_move) continue;
    EXPECT_NEAR(at(figures, pointer.c_str()), 0, 2e-4) << pointer;
  }
}

TEST(EvaluateRun, OfAnExactRunAllErrorsAreNothing) {
  const json f = figuresOf({});
  EXPECT_TRUE(f["missing"].empty()) << f["missing"];
  expectNoOtherError(f, {});
  EXPECT_EQ(f["photos"]["total"], 16);
  EXPECT_EQ(f["photos"]["posed"], 16);
  EXPECT_NEAR(at(f, "/trajectory/none/rmse_m"), 0, 1e-5);
  EXPECT_NEAR(at(f, "/trajectory/sim3/scale"), 1, 1e-6);
  EXPECT_NEAR(at(f, "/cloud/completeness"), 1, 1e-9);
  EXPECT_NEAR(at(f, "/cloud/coverage"), 1, 1e-9);
  EXPECT_NEAR(at(f, "/cloud/height/within_1_matched_pixel"), 1, 1e-9);
  // 400 x 300 matched at 0.03 MP: half the size, from about 50 m.
  EXPECT_NEAR(at(f, "/cloud/matched_pixel_m"), 50 * 2 / 320.0, 0.02);
  EXPECT_NEAR(at(f, "/depth/completeness"), 1, 1e-9);
  EXPECT_GT(at(f, "/seam/all/places"), 500);
  EXPECT_NEAR(at(f, "/camera/per_uav/a/before/focal_error_pct"), 3, 1e-6);
  // Truth 0.5 m, estimated 1 m.
  EXPECT_NEAR(f["gnss"]["per_uav"]["a"]["sigma_ratio"][0].get<double>(), 2, 1e-9);
}

TEST(EvaluateRun, ScaleOverTime) {
  const json f = figuresOf({});
  const json a = f["scale"]["segments"]["a"]["0"];
  EXPECT_EQ(a["history"].size(), 7u);
  EXPECT_NEAR(a["history"][0][1].get<double>(), 5, 1e-4);
  EXPECT_EQ(a["photos_to_converge"], 2);
  EXPECT_TRUE(a["after_15"].is_null());  // there are but eight
  EXPECT_NEAR(a["sigma_end_pct"].get<double>(), 1, 1e-6);
  EXPECT_NEAR(at(f, "/scale/consistency/within_3_sigma"), 6.0 / 7, 1e-9);  // 0.35 / 0.07 = 5
  // Fixes of 0.5 m at (0, +-30) and (+-40, 0), the outlier left out.
  const double bound = 100 * 0.5 / std::sqrt(2 * 900 + 2 * 1600);
  EXPECT_NEAR(a["end"]["bound_sigma_pct"].get<double>(), bound, 1e-6);
  EXPECT_NEAR(a["end"]["limit_pct"].get<double>(), 3 * bound, 1e-6);
  EXPECT_EQ(a["end"]["within_limit"], true);
  EXPECT_NEAR(f["scale"]["map"]["a"]["error_pct"].get<double>(), 0, 1e-4);
  EXPECT_TRUE(f["scale"]["within_limits"]["after_15"].is_null());
  EXPECT_EQ(f["scale"]["within_limits"]["end"], true);

  Faults faults;
  faults.scale_estimate = 1.02;
  const json wrong = figuresOf(faults);
  expectNoOtherError(wrong, {"/scale"});
  EXPECT_NEAR(at(wrong, "/scale/error_end_pct/max"), 2, 1e-4);
  EXPECT_TRUE(wrong["scale"]["segments"]["b"]["0"]["photos_to_converge"].is_null());
  EXPECT_NEAR(at(wrong, "/scale/consistency/within_1_sigma"), 0, 1e-9);
  EXPECT_EQ(wrong["scale"]["within_limits"]["end"], true);  // 2 % of 2.1 %
  faults.scale_estimate = 1.03;
  EXPECT_EQ(figuresOf(faults)["scale"]["within_limits"]["end"], false);
}

TEST(EvaluateRun, ScaleAfter15PhotosAndOfTheMap) {
  Faults faults;
  faults.photos = 20;
  faults.scale_estimate = 1.04;
  faults.map_scale = 1.002;
  const json f = figuresOf(faults);
  const json a = f["scale"]["segments"]["a"]["0"];
  EXPECT_EQ(a["history"].size(), 19u);
  EXPECT_NEAR(a["after_15"]["error_pct"].get<double>(), 4, 1e-4);
  // Three of the fixes are as old as the 15th photo.
  const double bound = 100 * 0.5 / std::sqrt(900 + 900 + 1600 - std::pow(40 / 3.0, 2) * 3);
  EXPECT_NEAR(a["after_15"]["bound_sigma_pct"].get<double>(), bound, 1e-6);
  EXPECT_NEAR(a["after_15"]["limit_pct"].get<double>(), 3 * bound, 1e-6);
  EXPECT_EQ(a["after_15"]["within_limit"], false);
  EXPECT_EQ(f["scale"]["within_limits"]["after_15"], false);
  EXPECT_NEAR(f["scale"]["map"]["b"]["error_pct"].get<double>(), 0.2, 1e-4);
  EXPECT_EQ(f["scale"]["within_limits"]["map"], true);
}

TEST(EvaluateRun, AMapTooLarge) {
  Faults faults;
  faults.map_scale = 1.02;
  const json f = figuresOf(faults);
  expectNoOtherError(f, {"/trajectory/se3", "/depth/as_is"});
  EXPECT_NEAR(at(f, "/trajectory/sim3/scale"), 1 / 1.02, 1e-6);
  EXPECT_GT(at(f, "/trajectory/se3/rmse_m"), 0.2);
  EXPECT_NEAR(at(f, "/depth/as_is/m/bias"), 0.02 * 50, 0.02);
}

/// Errors of poses over what is told of them, in the world and after one similarity.
TEST(EvaluateRun, CovariancesOfPoses) {
  const json exact = figuresOf({});
  EXPECT_NEAR(at(exact, "/consistency/world/nees"), 0, 1e-6);
  EXPECT_EQ(exact["consistency"]["world"]["photos"], 16);
  EXPECT_EQ(exact["consistency"]["world"]["inside"], false) << "too good to be true";

  Faults faults;
  faults.map_scale = 1.02;
  const json scaled = figuresOf(faults);
  const double error = at(scaled, "/consistency/world/error_m");
  EXPECT_NEAR(error, 0.02 * 54.6, 0.03);  // as far out as the cameras are
  EXPECT_NEAR(at(scaled, "/consistency/world/nees"),
              std::pow(error / SimulatedRun::kPoseSigma_m, 2), 1e-3);
  EXPECT_EQ(scaled["consistency"]["world"]["inside"], true);
  EXPECT_NEAR(at(scaled, "/consistency/world/sigma_m"), SimulatedRun::kPoseSigma_m * std::sqrt(3),
              1e-6);
  EXPECT_NEAR(at(scaled, "/consistency/map/nees"), 0, 1e-4) << "photos lie well to each other";

  faults = {};
  faults.shift_b_m = {0, 0, 1};
  const json shifted = figuresOf(faults);
  EXPECT_NEAR(at(shifted, "/consistency/world/nees"), 0.5 / std::pow(SimulatedRun::kPoseSigma_m, 2),
              1e-3);
  EXPECT_GT(at(shifted, "/consistency/map/nees"), 15) << "they do not";
  EXPECT_EQ(shifted["consistency"]["map"]["inside"], false);
  EXPECT_LT(at(shifted, "/consistency/map/photos_within_chi2_95"), 0.9);
}

TEST(EvaluateRun, OneUavShiftedByAMetre) {
  Faults faults;
  faults.shift_b_m = {0, 0, 1};
  const json f = figuresOf(faults);
  EXPECT_NEAR(at(f, "/uav_pairs/translation_rms_m"), 1, 0.01);
  EXPECT_NEAR(at(f, "/uav_pairs/pairs/0/vertical_m"), 1, 0.01);
  EXPECT_NEAR(at(f, "/uav_pairs/rotation_rms_deg"), 0, 5e-4);
  EXPECT_NEAR(at(f, "/seam/all/vertical_m/median"), 1, 0.01);
  EXPECT_NEAR(at(f, "/seam/all/vertical_gsd/median"), 320 / 50.0, 0.2);
  EXPECT_NEAR(at(f, "/trajectory/per_uav/b/own_se3/rmse_m"), 0, 1e-4);
  EXPECT_GT(at(f, "/trajectory/per_uav/b/cluster_se3/rmse_m"), 0.05);

  faults.shift_b_m = {0, 1, 0};  // across the line between the two: no change of scale or tilt
  const json sideways = figuresOf(faults);
  EXPECT_NEAR(at(sideways, "/uav_pairs/pairs/0/horizontal_m"), 1, 0.01);
  EXPECT_NEAR(at(sideways, "/seam/all/horizontal_m/median"), 1, 0.01);
  EXPECT_NEAR(at(sideways, "/seam/all/vertical_m/median"), 0, 0.05);
}

TEST(EvaluateRun, OneUavTurned) {
  Faults faults;
  faults.turn_b_deg = 0.1;
  const json f = figuresOf(faults);
  EXPECT_NEAR(at(f, "/uav_pairs/rotation_rms_deg"), 0.1, 1e-4);
  expectNoOtherError(
      f, {"/trajectory", "/uav_pairs", "/seam", "/ground", "/doming", "/depth/scaled", "/cloud"});
}

TEST(EvaluateRun, ABentMap) {
  Faults faults;
  faults.bend_per_m = 1e-5;
  const double once = at(figuresOf(faults), "/doming/span_m");
  faults.bend_per_m = 2e-5;
  const double twice = at(figuresOf(faults), "/doming/span_m");
  // The photos reach some 55 m east and west, 35 m north and south.
  EXPECT_NEAR(once, 1e-5 * (55 * 55 + 35 * 35), 0.4 * once);
  EXPECT_NEAR(twice, 2 * once, 0.02 * twice);
}

TEST(EvaluateRun, WrongFocalLength) {
  Faults faults;
  faults.focal = 1.01;
  const json f = figuresOf(faults);
  EXPECT_NEAR(at(f, "/camera/focal_rms_pct"), 1, 1e-6);
  EXPECT_NEAR(at(f, "/camera/per_uav/b/after/displacement_max_px"), 0.01 * std::hypot(199.5, 149.5),
              1e-6);
  EXPECT_NEAR(at(f, "/camera/per_uav/b/focal_error_over_sigma"), 2, 1e-6);
  // The ground looks 1 % farther away.
  EXPECT_NEAR(at(f, "/ground/all/vertical_m/bias"), -0.5, 0.05);
  expectNoOtherError(f, {"/camera", "/ground", "/seam", "/doming"});
}

TEST(EvaluateRun, DepthsOffAndLost) {
  Faults faults;
  faults.depth_offset_m = 0.3;
  faults.depth_rows_lost = 15;  // of 75
  const json f = figuresOf(faults);
  expectNoOtherError(f, {"/depth"});
  EXPECT_NEAR(at(f, "/depth/as_is/m/bias"), 0.3, 1e-4);
  EXPECT_NEAR(at(f, "/depth/as_is/m/p95"), 0.3, 1e-4);
  EXPECT_NEAR(at(f, "/depth/as_is/m/nmad"), 0, 1e-4);
  EXPECT_NEAR(at(f, "/depth/as_is/matched_pixels/bias"), 0.3 / (50 * 4 / 320.0), 0.03);
  EXPECT_NEAR(at(f, "/depth/completeness"), 0.8, 0.03);
}

TEST(EvaluateRun, ACloudTooHighAndPointsInTheAir) {
  Faults faults;
  faults.cloud_rise_m = 0.2;
  faults.flying_every = 20;
  const json f = figuresOf(faults);
  expectNoOtherError(f, {"/cloud"});
  EXPECT_NEAR(at(f, "/cloud/height/m/bias"), 0.2, 1e-4);
  EXPECT_NEAR(at(f, "/cloud/height/without_bend_m/bias"), 0, 1e-3);
  EXPECT_NEAR(at(f, "/cloud/flying/share"), 0.05, 1e-6);
  EXPECT_NEAR(at(f, "/cloud/height/within_1_matched_pixel"), 0.95, 0.01);
  faults.cloud_rise_m = 0.9;  // more than the reach of 2 matched pixels, 0.625 m
  EXPECT_NEAR(at(figuresOf(faults), "/cloud/completeness"), 0, 1e-9);
}

TEST(EvaluateRun, ReceiversAndObservedRelativePoses) {
  Faults faults;
  faults.bias_common_m = 4;
  const json common = figuresOf(faults);
  expectNoOtherError(common, {});
  EXPECT_NEAR(common["gnss"]["common_bias_error_m"][0].get<double>(), 4, 1e-9);

  faults.bias_b_m = 1;
  faults.relative_turn_deg = 0.5;
  const json f = figuresOf(faults);
  expectNoOtherError(f, {"/gnss", "/relative_poses"});
  EXPECT_NEAR(at(f, "/gnss/relative_bias_rms_m/horizontal"), 0.5, 1e-9);
  EXPECT_NEAR(at(f, "/relative_poses/rotation_deg/rms"), 0.5, 1e-6);
  EXPECT_NEAR(at(f, "/relative_poses/direction_deg/rms"), 0, 1e-5);
  EXPECT_NEAR(at(f, "/relative_poses/consistency_rotation/within_chi2_95"), 0, 1e-9);
  EXPECT_NEAR(at(f, "/relative_poses/consistency_translation/within_chi2_95"), 1, 1e-9);
}

TEST(EvaluateRun, WhatIsNotThereIsSaid) {
  Faults faults;
  faults.depth_maps = false;
  faults.photo_lost = true;
  const SimulatedRun run(faults);
  for (const char* file : {"out/cloud/cloud.ply", "out/odometry/a.tum", "out/odometry/b.tum"})
    std::filesystem::remove(run.out().parent_path() / file);
  const std::string text = evaluateRun(run.out(), run.truth());
  const json f = json::parse(text);
  EXPECT_EQ(f["photos"]["posed"], 15);
  EXPECT_EQ(f["photos"]["per_uav"]["b"]["posed"], 7);
  EXPECT_EQ(f["missing"].size(), 3u) << f["missing"];
  for (const char* name : {"depth", "cloud", "scale"}) {
    EXPECT_TRUE(f[name].is_null());
    EXPECT_FALSE(f["missing"][name].get<std::string>().empty());
  }
  expectNoOtherError(
      [&] {
        json patched = f;
        for (const char* name : {"depth", "cloud", "scale"}) patched[name] = json::object();
        return patched;
      }(),
      {"/depth", "/cloud", "/scale"});

  const std::string table = runTable(text);
  EXPECT_NE(table.find("15 of 16"), std::string::npos) << table;
  EXPECT_NE(table.find("no depth: the run has no depth maps"), std::string::npos) << table;
}

TEST(EvaluateRun, SeamsWithoutTrueDepthMaps) {
  Faults faults;
  faults.shift_b_m = {0, 0, 1};
  const SimulatedRun run(faults);
  std::filesystem::remove_all(run.truth() / "depth");
  const json f = json::parse(evaluateRun(run.out(), run.truth()));
  EXPECT_EQ(f["missing"].size(), 1u) << f["missing"];
  EXPECT_TRUE(f["depth"].is_null());
  EXPECT_GT(at(f, "/seam/all/places"), 500);
  EXPECT_NEAR(at(f, "/seam/all/vertical_m/median"), 1, 0.01);
  EXPECT_NEAR(at(f, "/cloud/matched_pixel_m"), 50 * 2 / 320.0, 0.02);
}

TEST(EvaluateRun, FoldersThatAreNotWhatTheyShouldBeAreNamed) {
  const SimulatedRun run({});
  const auto errorOf = [](const std::filesystem::path& out, const std::filesystem::path& truth) {
    try {
      static_cast<void>(evaluateRun(out, truth));
    } catch (const RunError& e) {
      return std::string(e.what());
    }
    return std::string("no error");
  };
  EXPECT_NE(errorOf(run.out(), run.out()).find("images.tsv"), std::string::npos);
  EXPECT_NE(errorOf(run.truth(), run.truth()).find("images/<uav>.csv"), std::string::npos);
  support::writeText(run.truth() / "depth/a/a_0003.tif", "nonsense");
  EXPECT_NE(errorOf(run.out(), run.truth()).find("a_0003.tif"), std::string::npos);
}

}  // namespace
}  // namespace cf
