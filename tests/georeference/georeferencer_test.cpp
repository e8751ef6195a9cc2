// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "georeference/flight.h"

namespace cf {
namespace {

using test::Flight;
using test::FlightPlan;

double rmsPosition(const Georeferencer& stage, const Flight& flight, bool horizontal = false) {
  double sum = 0;
  int count = 0;
  for (const GeoSegment& segment : stage.segments())
    for (const auto& pose : segment.poses) {
      const auto e = test::errorOf(pose, flight.T_world_cam[pose.frame.index]);
      sum += e.head(horizontal ? 2 : 3).squaredNorm();
      ++count;
    }
  return std::sqrt(sum / count);
}

TEST(Georeferencer, RecoversScaleAndPosesExactlyWithoutNoise) {
  FlightPlan plan;
  plan.vo_rotation_deg = plan.vo_step = plan.vo_depth = 0;
  plan.sigma_m.setZero();
  const Flight flight = test::fly(plan, 1);
  const Georeferencer stage = test::run(flight);
  ASSERT_EQ(stage.segments().size(), 1u);
  const GeoSegment& segment = stage.segments()[0];
  ASSERT_TRUE(segment.georeferenced);
  EXPECT_NEAR(segment.scale, flight.scale, 1e-3 * flight.scale);
  ASSERT_EQ(segment.poses.size(), flight.keyframes.size());
  for (const auto& pose : segment.poses) {
    const auto e = test::errorOf(pose, flight.T_world_cam[pose.frame.index]);
    EXPECT_LT(e.head<3>().norm(), 0.05);
    EXPECT_LT(e.tail<3>().norm(), 1e-3);
  }
}

TEST(Georeferencer, NoisyFlightIsBetterThanItsFixes) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Flight flight = test::fly({}, seed);
    const Georeferencer stage = test::run(flight);
    ASSERT_TRUE(stage.segments()[0].georeferenced);
    EXPECT_NEAR(stage.segments()[0].scale / flight.scale, 1, 0.03) << seed;
    EXPECT_LT(rmsPosition(stage, flight), 2.0) << seed;  // the fixes: 3.7 m
    const GnssQuality quality = stage.quality();
    EXPECT_TRUE(quality.trusted);
    EXPECT_NEAR(quality.sigma_m.x(), 1.5, 0.6);
    EXPECT_NEAR(quality.sigma_m.z(), 3.0, 1.2);
    EXPECT_EQ(quality.fixes, 48);
  }
}

TEST(Georeferencer, NoiseIsEstimatedWhateverTheTagSays) {
  FlightPlan plan;
  plan.sigma_m = {0.4, 0.4, 1.0};
  plan.tagged_m = {2, 2, 4};
  const Georeferencer stage = test::run(test::fly(plan, 3));
  EXPECT_LT(stage.quality().sigma_m.x(), 1.0);
  EXPECT_LT(stage.quality().sigma_m.z(), 2.0);
}

TEST(Georeferencer, TagsThatAreFarTooSmallDoNoHarm) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    FlightPlan plan;
    plan.sigma_m = {0.5, 0.5, 0.5};
    plan.tagged_m = {0.02, 0.02, 0.03};
    plan.pitch_deg = 16;
    const Flight flight = test::fly(plan, seed);
    const Georeferencer stage = test::run(flight);
    const auto e = test::errorOf(stage.segments()[0].poses[20], flight.T_world_cam[20]);
    EXPECT_LT(e.tail<3>().norm(), 1 * M_PI / 180) << seed;
    EXPECT_NEAR(stage.quality().sigma_m.x(), 0.5, 0.25) << seed;
    EXPECT_TRUE(stage.quality().trusted);
  }
}

TEST(Georeferencer, TenPercentOutliersAreNamedAndHarmless) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    Flight flight = test::fly({}, seed);
    const double clean = rmsPosition(test::run(flight), flight);
    for (std::size_t i = 3; i < flight.fixes.size(); i += 10) {
      flight.fixes[i].longitude_deg += 40;
      flight.fixes[i].latitude_deg -= 60;
    }
    const Georeferencer stage = test::run(flight);
    EXPECT_LT(rmsPosition(stage, flight), clean + 0.7) << seed;
    EXPECT_NEAR(stage.segments()[0].scale / flight.scale, 1, 0.03) << seed;
    EXPECT_GE(stage.quality().outliers, 5);
    EXPECT_LE(stage.quality().outliers, 7);
    EXPECT_TRUE(stage.quality().trusted);
  }
}

TEST(Georeferencer, FixesThatCannotBeAreNotUsed) {
  Flight flight = test::fly({}, 1);
  const Georeferencer clean = test::run(flight);
  GnssFix nowhere = flight.fixes[10], certain = flight.fixes[20], unsure = flight.fixes[30];
  nowhere.longitude_deg = std::nan("");
  certain.sigma_enu_m.z() = 0;
  unsure.sigma_enu_m.x() = std::nan("");
  flight.fixes.insert(flight.fixes.end(), {nowhere, certain, unsure});
  const Georeferencer stage = test::run(flight);
  EXPECT_EQ(stage.quality().fixes, 48);
  ASSERT_TRUE(stage.segments()[0].georeferenced);
  EXPECT_EQ(stage.segments()[0].scale, clean.segments()[0].scale);
}

TEST(Georeferencer, OutageIsBridgedByOdometry) {
  Flight flight = test::fly({}, 4);
  flight.fixes.erase(flight.fixes.begin() + 15, flight.fixes.begin() + 30);
  Georeferencer stage(0, {}, test::metresAsDegrees);
  for (const GnssFix& fix : flight.fixes) stage.addFix(fix);
  std::vector<GeoKeyframe> all;
  for (const auto& keyframe : flight.keyframes)
    for (auto& geo : stage.push(keyframe)) all.push_back(geo);
  for (auto& geo : stage.flush()) all.push_back(geo);
  ASSERT_EQ(all.size(), flight.keyframes.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(all[i].keyframe->id.index, i);
    EXPECT_EQ(all[i].fix.has_value(), i < 15 || i >= 30);
  }
  EXPECT_LT(rmsPosition(stage, flight), 3.0);
  const auto& poses = stage.segments()[0].poses;
  EXPECT_GT(poses[22].covariance.topLeftCorner(3, 3).trace(),
            poses[5].covariance.topLeftCorner(3, 3).trace());
}

TEST(Georeferencer, GarbageAltitudeDoesNotBendTheMap) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    Flight flight = test::fly({}, seed);
    for (std::size_t i = 0; i < flight.fixes.size(); ++i)
      flight.fixes[i].height_m += 50 * std::sin(0.4 * static_cast<double>(i)) + flight.normal(20);
    const Georeferencer stage = test::run(flight);
    EXPECT_NEAR(stage.segments()[0].scale / flight.scale, 1, 0.04) << seed;
    EXPECT_LT(rmsPosition(stage, flight, true), 2.0) << seed;
    EXPECT_GT(stage.quality().sigma_m.z(), 20);
    EXPECT_LT(stage.quality().sigma_m.x(), 3);
    EXPECT_TRUE(stage.quality().trusted);
  }
}

TEST(Georeferencer, JunkIsNotTrustedAndKeepsTheShapeOfOdometry) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    FlightPlan plan;
    plan.sigma_m = {15, 15, 40};
    plan.tagged_m = {2, 2, 4};
    plan.points = true;
    const Flight flight = test::fly(plan, seed);
    const Georeferencer stage = test::run(flight);
    EXPECT_FALSE(stage.quality().trusted) << seed;
    const GeoSegment& segment = stage.segments()[0];
    ASSERT_TRUE(segment.georeferenced);
    for (std::size_t i = 1; i < segment.poses.size(); ++i) {
      // Steps are those of odometry, times the scale.
      const Eigen::Vector3d step =
          (segment.poses[i - 1].T_world_cam.inverse() * segment.poses[i].T_world_cam).translation();
      const Eigen::Vector3d vo =
          (flight.keyframes[i - 1]->T_local_cam.inverse() * flight.keyframes[i]->T_local_cam)
              .translation();
      EXPECT_LT((step - segment.scale * vo).norm(), 0.02 * step.norm());
    }
  }
}

TEST(Georeferencer, DriftingJunkDoesNotTiltTheMap) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    FlightPlan plan;
    plan.sigma_m = {0.5, 0.5, 0.5};
    plan.tagged_m = {2, 2, 4};
    Flight flight = test::fly(plan, seed);
    for (std::size_t i = 0; i < flight.fixes.size(); ++i) {
      const double t = static_cast<double>(i);
      flight.fixes[i].longitude_deg += 15 * std::sin(0.31 * t);
      flight.fixes[i].latitude_deg += 20 * std::cos(0.23 * t);
      flight.fixes[i].height_m += 2.3 * t;  // 110 m in all, most of it along the flight
    }
    const Georeferencer stage = test::run(flight);
    EXPECT_FALSE(stage.quality().trusted) << seed;
    const GeoSegment& segment = stage.segments()[0];
    ASSERT_TRUE(segment.georeferenced);
    EXPECT_LT(std::abs(segment.scale - flight.scale), 3 * segment.scale_sigma) << seed;
    const auto e = test::errorOf(segment.poses[20], flight.T_world_cam[20]);
    EXPECT_LT(e.segment<2>(3).norm(), 10 * M_PI / 180) << seed;
  }
}

TEST(Georeferencer, PhotosOfOnePlaceHaveNoScale) {
  FlightPlan plan;
  plan.per_line = 1;
  plan.lines = 8;
  plan.spacing_m = 0;
  Flight flight = test::fly(plan, 1);
  for (const auto& keyframe : flight.keyframes)
    keyframe->T_local_cam = flight.keyframes[0]->T_local_cam;
  const Georeferencer stage = test::run(flight);
  EXPECT_FALSE(stage.segments()[0].georeferenced);
  EXPECT_EQ(stage.segments()[0].poses.size(), 8u);
}

TEST(Georeferencer, WithoutFixesStaysLocal) {
  Flight flight = test::fly({}, 1);
  flight.fixes.clear();
  Georeferencer stage(0, {}, test::metresAsDegrees);
  std::size_t left = 0;
  for (const auto& keyframe : flight.keyframes) left += stage.push(keyframe).size();
  EXPECT_EQ(left, flight.keyframes.size() - 5);  // max_wait_keyframes
  left += stage.flush().size();
  EXPECT_EQ(left, flight.keyframes.size());
  const GeoSegment& segment = stage.segments()[0];
  EXPECT_FALSE(segment.georeferenced);
  EXPECT_TRUE(segment.poses[7].T_world_cam.isApprox(flight.keyframes[7]->T_local_cam));
  EXPECT_EQ(stage.quality().fixes, 0);
  EXPECT_FALSE(stage.quality().trusted);
}

TEST(Georeferencer, SegmentsHaveTheirOwnScale) {
  Flight flight = test::fly({}, 2);
  for (std::size_t i = 24; i < 48; ++i) {
    flight.keyframes[i]->segment = 1;
    Eigen::Isometry3d& T = flight.keyframes[i]->T_local_cam;
    T.translation() *= 4;
    T = Eigen::AngleAxisd(1, Eigen::Vector3d::UnitX()) * T;
  }
  const Georeferencer stage = test::run(flight);
  ASSERT_EQ(stage.segments().size(), 2u);
  EXPECT_NEAR(stage.segments()[0].scale / flight.scale, 1, 0.05);
  EXPECT_NEAR(stage.segments()[1].scale / (flight.scale / 4), 1, 0.05);
  EXPECT_LT(rmsPosition(stage, flight), 3);
  EXPECT_EQ(stage.scaleHistory().size(), 48u);
  EXPECT_EQ(stage.scaleHistory().back().segment, 1);
}

TEST(Georeferencer, LoneTaggedPhotoIsPlacedByFixAndGimbal) {
  FlightPlan plan;
  plan.lines = 1;
  plan.per_line = 1;
  plan.gimbal = true;
  plan.attitude_deg = 0;
  const Flight flight = test::fly(plan, 5);
  const Georeferencer stage = test::run(flight);
  ASSERT_TRUE(stage.segments()[0].georeferenced);
  const auto& pose = stage.segments()[0].poses[0];
  const auto e = test::errorOf(pose, flight.T_world_cam[0]);
  EXPECT_LT(e.tail<3>().norm(), 0.02);
  EXPECT_NEAR(std::sqrt(pose.covariance(5, 5)), 10 * M_PI / 180, 0.02);
  EXPECT_NEAR(std::sqrt(pose.covariance(3, 3)), 2 * M_PI / 180, 0.005);

  plan.gimbal = false;
  EXPECT_FALSE(test::run(test::fly(plan, 5)).segments()[0].georeferenced);
}

TEST(Georeferencer, TwoPhotosAreEnoughWhenFarApart) {
  FlightPlan plan;
  plan.lines = 1;
  plan.per_line = 2;
  plan.step_m = 30;
  plan.points = true;
  plan.sigma_m = {0.5, 0.5, 0.5};
  plan.tagged_m = {1, 1, 1};
  const Flight flight = test::fly(plan, 6);
  const Georeferencer stage = test::run(flight);
  const GeoSegment& segment = stage.segments()[0];
  ASSERT_TRUE(segment.georeferenced);
  EXPECT_LT(std::abs(segment.scale - flight.scale), 3 * segment.scale_sigma);
  EXPECT_LT(segment.scale_sigma, 0.1 * flight.scale);
}

TEST(Georeferencer, LongSegmentsSolvedInWindowsEndAsInOneGo) {
  FlightPlan plan;
  plan.lines = 5;
  plan.per_line = 30;
  const Flight flight = test::fly(plan, 7);
  GeoreferenceOptions windows;
  windows.full_solve_keyframes = 20;
  windows.window_keyframes = 10;
  Georeferencer online(0, windows, test::metresAsDegrees);
  for (const GnssFix& fix : flight.fixes) online.addFix(fix);
  for (const auto& keyframe : flight.keyframes) online.push(keyframe);
  EXPECT_LT(rmsPosition(online, flight), 2.5);
  EXPECT_NEAR(online.segments()[0].scale / flight.scale, 1, 0.02);
  online.flush();
  const Georeferencer whole = test::run(flight);
  EXPECT_NEAR(online.segments()[0].scale, whole.segments()[0].scale, 1e-3 * flight.scale);
}

TEST(Georeferencer, IsDeterministic) {
  const Flight flight = test::fly({}, 8);
  const Georeferencer a = test::run(flight), b = test::run(flight);
  for (std::size_t i = 0; i < a.segments()[0].poses.size(); ++i) {
    EXPECT_EQ(a.segments()[0].poses[i].T_world_cam.matrix(),
              b.segments()[0].poses[i].T_world_cam.matrix());
    EXPECT_EQ(a.segments()[0].poses[i].covariance, b.segments()[0].poses[i].covariance);
  }
  EXPECT_EQ(a.graphText(), b.graphText());
}

}  // namespace
}  // namespace cf
