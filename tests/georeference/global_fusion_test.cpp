// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "cf/base/error.h"
#include "cf/config/config.h"
#include "georeference/flight.h"

namespace cf {
namespace {

using test::Flight;
using test::FlightPlan;

GeoreferenceOptions baseline() {
  GeoreferenceOptions options;
  options.method = "global_fusion";
  return options;
}

double rmsPosition(const GeoSegment& segment, const Flight& flight) {
  double sum = 0;
  for (const auto& pose : segment.poses)
    sum += test::errorOf(pose, flight.T_world_cam[pose.frame.index]).head<3>().squaredNorm();
  return std::sqrt(sum / static_cast<double>(segment.poses.size()));
}

FlightPlan exact() {
  FlightPlan plan;
  plan.vo_rotation_deg = plan.vo_step = plan.vo_depth = 0;
  plan.sigma_m.setZero();
  return plan;
}

/// Odometry whose steps grow steadily, to (1 + drift) times their length at the end.
void addScaleDrift(Flight& flight, double drift) {
  Eigen::Isometry3d before = flight.keyframes[0]->T_local_cam;
  const std::size_t n = flight.keyframes.size();
  for (std::size_t i = 1; i < n; ++i) {
    const Eigen::Isometry3d now = flight.keyframes[i]->T_local_cam;
    Eigen::Isometry3d T_i_j = before.inverse() * now;
    T_i_j.translation() *= 1 + drift * static_cast<double>(i) / static_cast<double>(n - 1);
    flight.keyframes[i]->T_local_cam = flight.keyframes[i - 1]->T_local_cam * T_i_j;
    before = now;
  }
}

TEST(GlobalFusion, RecoversScaleAndPosesExactlyWithoutNoise) {
  const Flight flight = test::fly(exact(), 1);
  const Georeferencer stage = test::run(flight, baseline());
  ASSERT_EQ(stage.segments().size(), 1u);
  const GeoSegment& segment = stage.segments()[0];
  ASSERT_TRUE(segment.georeferenced);
  EXPECT_NEAR(segment.scale, flight.scale, 1e-3 * flight.scale);
  for (const auto& pose : segment.poses) {
    const auto e = test::errorOf(pose, flight.T_world_cam[pose.frame.index]);
    EXPECT_LT(e.head<3>().norm(), 0.05);
    EXPECT_LT(e.tail<3>().norm(), 1e-3);
  }
}

TEST(GlobalFusion, NoisyFlightIsBetterThanItsFixes) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Flight flight = test::fly({}, seed);
    const Georeferencer stage = test::run(flight, baseline());
    ASSERT_TRUE(stage.segments()[0].georeferenced);
    EXPECT_LT(rmsPosition(stage.segments()[0], flight), 2.5) << seed;  // the fixes: 3.7 m
    EXPECT_EQ(stage.quality().outliers, 0);
  }
}

TEST(GlobalFusion, TheScaleOfTheFirstFixesStaysInTheIncrements) {
  // The first line's fixes are stretched by a tenth along it; from the second on all is exact.
  Flight flight = test::fly(exact(), 2);
  for (std::size_t i = 0; i < 12; ++i)
    flight.fixes[i].longitude_deg += 0.1 * flight.T_world_cam[i].translation().x();
  const GeoSegment two_stage = test::run(flight).segments()[0];
  const GeoSegment fusion = test::run(flight, baseline()).segments()[0];
  EXPECT_NEAR(two_stage.scale / flight.scale, 1, 0.01);
  EXPECT_GT(fusion.scale / flight.scale, 1.02);
  EXPECT_GT(rmsPosition(fusion, flight), 1.5 * rmsPosition(two_stage, flight));
}

TEST(GlobalFusion, ScaleDriftOfOdometryShowsAsError) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    Flight flight = test::fly(exact(), seed);
    addScaleDrift(flight, 0.2);
    const GeoSegment two_stage = test::run(flight).segments()[0];
    const GeoSegment fusion = test::run(flight, baseline()).segments()[0];
    EXPECT_LT(two_stage.scale, fusion.scale) << seed;  // the truth: from 1 down to 1/1.2
    EXPECT_GT(rmsPosition(fusion, flight), 1) << seed;
    EXPECT_GT(rmsPosition(fusion, flight), 1.3 * rmsPosition(two_stage, flight)) << seed;
  }
}

TEST(GlobalFusion, LongSegmentsAreSolvedInWindows) {
  FlightPlan plan;
  plan.lines = 5;
  plan.per_line = 30;
  const Flight flight = test::fly(plan, 7);
  GeoreferenceOptions windows = baseline();
  windows.full_solve_keyframes = 20;
  windows.window_keyframes = 10;
  Georeferencer online(0, windows, test::metresAsDegrees);
  for (const GnssFix& fix : flight.fixes) online.addFix(fix);
  for (const auto& keyframe : flight.keyframes) online.push(keyframe);
  EXPECT_LT(rmsPosition(online.segments()[0], flight), 3);
  online.flush();
  EXPECT_LT(rmsPosition(online.segments()[0], flight), 2.5);
}

TEST(GlobalFusion, WithoutFixesStaysLocal) {
  Flight flight = test::fly({}, 1);
  flight.fixes.clear();
  const Georeferencer stage = test::run(flight, baseline());
  EXPECT_FALSE(stage.segments()[0].georeferenced);
  EXPECT_EQ(stage.segments()[0].poses.size(), flight.keyframes.size());
}

TEST(GeoreferenceMethod, MisspeltIsRejectedByNameAndByTheConfiguration) {
  GeoreferenceOptions options;
  options.method = "global_fusoin";
  EXPECT_THROW(Georeferencer(0, options, test::metresAsDegrees), UsageError);

  const auto ini = std::filesystem::path(::testing::TempDir()) / "cf_georeference_method.ini";
  const auto load = [&](const std::string& method) {
    std::ofstream(ini) << "[georeference]\nmethod = " << method << "\n";
    Config config = Config::fromFile(ini);
    config.load("georeference", options);
  };
  EXPECT_THROW(load("global_fusoin"), UsageError);
  load("global_fusion");
  EXPECT_EQ(options.method, "global_fusion");
  std::filesystem::remove(ini);
}

}  // namespace
}  // namespace cf
