// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// Normalised errors over many seeds against their chi-square bounds.
#include <gtest/gtest.h>

#include "georeference/flight.h"

namespace cf {
namespace {

using test::Flight;
using test::FlightPlan;

/// Only the estimate at the end counts here: little is solved on the way.
GeoreferenceOptions endOnly() {
  GeoreferenceOptions options;
  options.full_solve_keyframes = 1;
  options.window_keyframes = 2;
  return options;
}

/// Bounds of the mean of `n` chi-square variables of `dof` degrees of freedom, 99.9 % two-sided
/// (normal approximation of the sum).
void expectMeanChiSquare(double sum, int n, int dof, const char* what) {
  const double mean = sum / n;
  const double width = 3.3 * std::sqrt(2.0 * dof / n);
  EXPECT_GT(mean, std::max(0.0, dof - width)) << what;
  EXPECT_LT(mean, dof + width) << what;
  std::printf("  %s: mean normalised squared error %.2f for %d degrees of freedom\n", what, mean,
              dof);
}

TEST(Consistency, ScaleAndPositionErrorsMatchTheirCovariance) {
  GeoreferenceOptions options = endOnly();
  options.common_error = 0;  // no common bias is drawn here
  double scale_sum = 0, position_sum = 0, rotation_sum = 0;
  constexpr int kSeeds = 60;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    FlightPlan plan;
    const Flight flight = test::fly(plan, 100 + seed);
    const Georeferencer stage = test::run(flight, options);
    const GeoSegment& segment = stage.segments()[0];
    ASSERT_TRUE(segment.georeferenced);
    scale_sum += std::pow((segment.scale - flight.scale) / segment.scale_sigma, 2);
    const auto& pose = segment.poses[segment.poses.size() / 3];
    const auto e = test::errorOf(pose, flight.T_world_cam[pose.frame.index]);
    position_sum += e.head<3>().dot(
        Eigen::Matrix3d(pose.covariance.topLeftCorner<3, 3>()).ldlt().solve(e.head<3>()));
    rotation_sum += e.tail<3>().dot(
        Eigen::Matrix3d(pose.covariance.bottomRightCorner<3, 3>()).ldlt().solve(e.tail<3>()));
  }
  expectMeanChiSquare(scale_sum, kSeeds, 1, "scale");
  expectMeanChiSquare(position_sum, kSeeds, 3, "position");
  expectMeanChiSquare(rotation_sum, kSeeds, 3, "rotation");
}

TEST(Consistency, BiasOfTheReceiverIsInTheCovariance) {
  double sum = 0;
  constexpr int kSeeds = 30;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    FlightPlan plan;
    Flight flight = test::fly(plan, 300 + seed);
    const Eigen::Vector3d bias = plan.tagged_m.cwiseProduct(flight.normal3(1));
    for (GnssFix& fix : flight.fixes) {
      fix.longitude_deg += bias.x();
      fix.latitude_deg += bias.y();
      fix.height_m += bias.z();
    }
    const Georeferencer stage = test::run(flight, endOnly());
    const auto& pose = stage.segments()[0].poses[10];
    const Eigen::Vector3d e = test::errorOf(pose, flight.T_world_cam[10]).head<3>();
    sum += e.dot(Eigen::Matrix3d(pose.covariance.topLeftCorner<3, 3>()).ldlt().solve(e));
  }
  expectMeanChiSquare(sum, kSeeds, 3, "position with bias");
}

TEST(Consistency, RollAboutAStraightLineHasAnHonestSigma) {
  double sum = 0;
  constexpr int kSeeds = 40;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    FlightPlan plan;
    plan.lines = 1;
    plan.attitude_deg = 0.5;
    plan.tilt_deg = 15;  // as nadir_sigma_deg; flown east, so roll is about x
    const Flight flight = test::fly(plan, 500 + seed);
    const Georeferencer stage = test::run(flight, endOnly());
    const GeoSegment& segment = stage.segments()[0];
    ASSERT_TRUE(segment.georeferenced);
    const auto& pose = segment.poses[6];
    const auto e = test::errorOf(pose, flight.T_world_cam[6]);
    const double sigma = std::sqrt(pose.covariance(3, 3));
    EXPECT_GT(sigma, 8 * M_PI / 180);
    EXPECT_LT(sigma, 40 * M_PI / 180);
    sum += e(3) * e(3) / (sigma * sigma);
    EXPECT_LT(std::sqrt(pose.covariance(4, 4)), 5 * M_PI / 180);  // pitch: seen along the line
    EXPECT_LT(std::abs(segment.scale / flight.scale - 1), 5 * segment.scale_sigma / segment.scale);
  }
  expectMeanChiSquare(sum, kSeeds, 1, "roll");
}

TEST(Consistency, GroundPlaneSettlesTheRollOfAStraightLine) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    FlightPlan plan;
    plan.lines = 1;
    plan.tilt_deg = 12;
    plan.points = true;
    const Flight flight = test::fly(plan, 700 + seed);
    const Georeferencer stage = test::run(flight, endOnly());
    const auto& pose = stage.segments()[0].poses[6];
    const auto e = test::errorOf(pose, flight.T_world_cam[6]);
    EXPECT_LT(std::abs(e(3)), 10 * M_PI / 180);
    EXPECT_LT(std::sqrt(pose.covariance(3, 3)), 8 * M_PI / 180);
  }
}

TEST(Consistency, GimbalSettlesTheRollOfAStraightLine) {
  FlightPlan plan;
  plan.lines = 1;
  plan.gimbal = true;
  plan.pitch_deg = 16;
  plan.attitude_deg = 0.5;
  const Flight flight = test::fly(plan, 9);
  const Georeferencer stage = test::run(flight, endOnly());
  const auto& pose = stage.segments()[0].poses[6];
  EXPECT_LT(std::abs(test::errorOf(pose, flight.T_world_cam[6])(3)), 2 * M_PI / 180);
  EXPECT_NEAR(std::sqrt(pose.covariance(3, 3)), 2 * M_PI / 180, 0.01);
}

}  // namespace
}  // namespace cf
