// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/simulate/flight_plan.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cf/base/error.h"
#include "cf/types/image_frame.h"

namespace cf {
namespace {

constexpr double kDegrees = 180 / M_PI;
constexpr Footprint kFootprint{60, 80};
constexpr double kGround_m = 3;

FlightOptions calm() {
  FlightOptions o;
  o.wobble_sigma_deg = 0;
  o.drift_sigma_m = 0;
  return o;
}

Flight fly(const FlightOptions& options, std::uint64_t seed = 1) {
  return Flight(options, kFootprint, kGround_m, seed, "[uav.a] ");
}

std::vector<Eigen::Vector3d> photoPlaces(const Flight& flight) {
  std::vector<Eigen::Vector3d> places;
  for (const double t : flight.photoTimes()) places.push_back(flight.T_world_cam(t).translation());
  return places;
}

TEST(FlightPlan, keepsTheOverlapsAndCoversTheArea) {
  FlightOptions o = calm();
  o.length_m = 120;
  o.width_m = 90;
  o.center_e_m = 1000;
  o.forward_overlap = 0.75;  // 15 m
  o.side_overlap = 0.65;     // at most 28 m: 4 strips
  const Flight flight = fly(o);
  EXPECT_EQ(flight.strips(), 4U);
  const auto places = photoPlaces(flight);
  ASSERT_EQ(places.size(), 4U * 9U);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const std::size_t strip = i / 9;
    EXPECT_NEAR(places[i].x(), 1000 - 45 + (static_cast<double>(strip) + 0.5) * 22.5, 1e-6);
    const double along = -60 + static_cast<double>(i % 9) * 15;
    EXPECT_NEAR(places[i].y(), strip % 2 == 0 ? along : -along, 1e-4);
    EXPECT_NEAR(places[i].z(), kGround_m + o.height_m, 1e-9);
  }
}

TEST(FlightPlan, goesAcrossAgainWhereThePatternIsDouble) {
  FlightOptions o = calm();
  o.length_m = 100;
  o.width_m = 50;
  o.pattern = "double";
  const Flight flight = fly(o);
  EXPECT_EQ(flight.strips(), 2U + 4U);
  const double last = flight.photoTimes().back();
  EXPECT_NEAR(std::abs(flight.motionAt(last).velocity_mps.x()), o.speed_mps, 1e-6);
}

TEST(FlightPlan, holdsAGimbalStraightDownWithThePhotosTopAlongTheCourse) {
  FlightOptions o = calm();
  o.heading_deg = 30;
  const Flight flight = fly(o);
  const Eigen::Matrix3d expected = rotationWorldCam({30, -90, 0});
  EXPECT_LT((flight.T_world_cam(flight.photoTimes()[1]).linear() - expected).norm(), 1e-9);
}

TEST(FlightPlan, movesSmoothlyAtItsSpeedThroughTurnsToo) {
  for (const double radius : {4.0, 12.0, 40.0}) {  // spacing 26.7 m: wide and bulb-shaped turns
    FlightOptions o = calm();
    o.turn_radius_m = radius;
    const Flight flight = fly(o);
    constexpr double kStep = 0.01;
    double most_turn = 0;
    for (double t = 0; t < flight.duration_s(); t += kStep) {
      const Eigen::Isometry3d a = flight.T_world_body(t), b = flight.T_world_body(t + kStep);
      ASSERT_NEAR((b.translation() - a.translation()).norm(), o.speed_mps * kStep, 1e-3) << t;
      most_turn =
          std::max(most_turn,
                   Eigen::AngleAxisd(Eigen::Matrix3d(a.linear().transpose() * b.linear())).angle());
    }
    EXPECT_NEAR(most_turn, o.speed_mps / radius * kStep, 1e-6) << radius;
  }
}

TEST(FlightPlan, givesVelocitiesThatAreThoseOfThePoses) {
  FlightOptions o;
  o.wobble_sigma_deg = 2;
  const Flight flight = fly(o);
  constexpr double kStep = 0.02;
  for (const double t : flight.photoTimes()) {
    const CameraMotion now = flight.motionAt(t);
    const Eigen::Isometry3d then = flight.T_world_cam(t + kStep);
    const Eigen::Vector3d moved = now.T_world_cam.translation() + kStep * now.velocity_mps;
    EXPECT_LT((moved - then.translation()).norm(), 2e-3);
    const Eigen::Vector3d w = now.angular_velocity_radps;
    const Eigen::Matrix3d turned =
        now.T_world_cam.linear() * Eigen::AngleAxisd(w.norm() * kStep, w.normalized()).matrix();
    EXPECT_LT((turned - then.linear()).norm(), 2e-3);
    EXPECT_GT(w.norm(), 1e-4);
  }
}

TEST(FlightPlan, disturbsByTheGivenSigmas) {
  FlightOptions o;
  o.length_m = 5000;
  o.wobble_sigma_deg = 2;
  o.drift_sigma_m = 0.5;
  o.width_m = 1;
  const Flight flight = fly(o);
  double tilt = 0, height = 0;
  for (const double t : flight.photoTimes()) {
    const Eigen::Isometry3d T = flight.T_world_cam(t);
    tilt += T.linear().col(2).head<2>().squaredNorm();
    height += std::pow(T.translation().z() - kGround_m - o.height_m, 2);
  }
  const double n = static_cast<double>(flight.photoTimes().size());
  EXPECT_NEAR(std::sqrt(tilt / n / 2) * kDegrees, 2, 0.3);  // two axes tilt it
  EXPECT_NEAR(std::sqrt(height / n), 0.5, 0.1);
}

TEST(FlightPlan, repeatsItselfForOneSeedAndNotForAnother) {
  const FlightOptions o;
  const Eigen::Isometry3d a = fly(o, 5).T_world_cam(7), b = fly(o, 5).T_world_cam(7),
                          c = fly(o, 6).T_world_cam(7);
  EXPECT_EQ(a.matrix(), b.matrix());
  EXPECT_GT((a.matrix() - c.matrix()).norm(), 1e-3);
}

TEST(FlightPlan, banksAFixedCameraInTurnsAndPointsItIntoTheWind) {
  FlightOptions o = calm();
  o.mount = "fixed";
  o.speed_mps = 15;
  o.turn_radius_m = 50;
  o.wind_speed_mps = 5;
  o.wind_from_deg = 270;
  o.photos_in_turns = true;
  const Flight flight = fly(o);
  double most = 0;
  for (const double t : flight.photoTimes()) {
    const Eigen::Vector3d axis = flight.T_world_cam(t).linear().col(2);
    most = std::max(most, std::acos(-axis.z()) * kDegrees);
  }
  EXPECT_NEAR(most, std::atan(15 * 15 / (9.81 * 50)) * kDegrees, 0.01);
  // On the first strip, northward, wind from the left: the nose turns left by atan(5 / 15).
  const Eigen::Vector3d nose = flight.T_world_body(flight.photoTimes()[1]).linear().col(0);
  EXPECT_NEAR(std::atan2(nose.x(), nose.y()) * kDegrees, -std::atan(5.0 / 15) * kDegrees, 1e-6);
}

TEST(FlightPlan, takesNoPhotosInGapsAndThoseInTurnsOnDemand) {
  FlightOptions o = calm();
  const std::size_t all = fly(o).photoTimes().size();
  o.gaps = "3:7, 20:22.5";
  const Flight with_gaps = fly(o);
  EXPECT_LT(with_gaps.photoTimes().size(), all);
  for (const double t : with_gaps.photoTimes())
    EXPECT_FALSE((t >= 3 && t <= 7) || (t >= 20 && t <= 22.5));
  o.gaps = "";
  o.photos_in_turns = true;
  EXPECT_GT(fly(o).photoTimes().size(), all);
}

TEST(FlightPlan, refusesAnAreaWithoutTwoPhotosAndGapsThatAreNone) {
  FlightOptions o = calm();
  o.length_m = 10;
  o.width_m = 5;
  try {
    fly(o);
    FAIL();
  } catch (const UsageError& e) {
    EXPECT_NE(std::string(e.what()).find("[uav.a] 1 photo on an area of 10 x 5 m"),
              std::string::npos)
        << e.what();
  }
  for (const char* gaps : {"3", "7:3", "3:7:9", "a:b", "3:7,,"}) {
    o = calm();
    o.gaps = gaps;
    EXPECT_THROW(fly(o), UsageError) << gaps;
  }
}

TEST(FlightPlan, sharesAnAreaSideBySide) {
  FlightOptions whole = calm();
  whole.heading_deg = 90;  // the right-hand side is south
  whole.width_m = 90;
  whole.center_n_m = 500;
  double north_edge = 545;
  for (int k = 0; k < 3; ++k) {
    const FlightOptions share = shareOf(whole, k, 3, 10);
    EXPECT_NEAR(share.center_n_m + share.width_m / 2, north_edge, 1e-9);
    EXPECT_NEAR(share.center_e_m, 0, 1e-9);
    EXPECT_NEAR(share.width_m, k == 1 ? 40 : 35, 1e-9);
    north_edge = share.center_n_m - share.width_m / 2 + 10;
  }
  EXPECT_NEAR(north_edge, 465, 1e-9);
}

}  // namespace
}  // namespace cf
