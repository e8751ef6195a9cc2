// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "inverse_depth_solver.h"

#include <gtest/gtest.h>

#include <random>

#include "support/views.h"

namespace cf {
namespace {

/// Six nadir cameras in a row over relief, every point seen by all, and its truth.
struct Scene {
  std::vector<AdjustedPose> poses;
  std::vector<AdjustedPoint> points;

  explicit Scene(double noise = 0) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> place(-40, 40), height(0, 12);
    std::normal_distribution<double> gauss;
    for (int i = 0; i < 6; ++i) {
      // The first at the origin of the local frame.
      const Eigen::Isometry3d T =
          support::nadirPose({12.0 * i, std::sin(2.0 * i), std::sin(3.0 * i)},
                             4 * std::sin(1.0 * i), 3 * std::sin(5.0 * i), 2 * std::sin(7.0 * i));
      poses.push_back({T.linear(), T.translation()});
    }
    for (int k = 0; k < 150; ++k) {
      const Eigen::Vector3d p(30 + place(random), place(random), height(random) - 60);
      AdjustedPoint point;
      point.anchor = k % 6;
      for (int i = 0; i < 6; ++i) {
        const auto& pose = poses[static_cast<std::size_t>(i)];
        const Eigen::Vector3d p_cam = pose.R.transpose() * (p - pose.t);
        const Eigen::Vector2d seen =
            p_cam.hnormalized() + noise * Eigen::Vector2d(gauss(random), gauss(random));
        if (i != point.anchor) {
          point.sightings.push_back({i, seen});
        } else {
          point.anchor_normalized = p_cam.hnormalized();
          point.inverse_depth = 1 / p_cam.z();
        }
      }
      points.push_back(point);
    }
  }

  /// All free poses and depths away from the truth.
  void disturb(double angle, double metres, double depth_share) {
    std::mt19937 random(5);
    std::normal_distribution<double> gauss;
    for (AdjustedPose& pose : poses) {
      if (pose.held) continue;
      const Eigen::Vector3d turn(gauss(random), gauss(random), gauss(random));
      pose.R = pose.R * Eigen::AngleAxisd(angle, turn.normalized());
      const double length = pose.t.norm();
      pose.t += metres * Eigen::Vector3d(gauss(random), gauss(random), gauss(random));
      if (pose.length_held) pose.t *= length / pose.t.norm();
    }
    for (AdjustedPoint& point : points) point.inverse_depth *= 1 + depth_share * gauss(random);
  }
};

double worstPosition(const Scene& a, const Scene& b) {
  double worst = 0;
  for (std::size_t i = 0; i < a.poses.size(); ++i)
    worst = std::max(worst, (a.poses[i].t - b.poses[i].t).norm());
  return worst;
}

TEST(InverseDepthSolver, FindsTheTruthBesideTwoHeldPoses) {
  Scene truth;
  truth.poses[0].held = truth.poses[1].held = true;
  Scene scene = truth;
  scene.disturb(0.02, 0.5, 0.05);
  ASSERT_TRUE(solveInverseDepths(scene.poses, scene.points, 0.01));
  EXPECT_LT(worstPosition(scene, truth), 1e-5);
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_LT(support::rotationErrorDeg(scene.poses[i].R, truth.poses[i].R), 1e-5);
  for (std::size_t k = 0; k < truth.points.size(); ++k)
    EXPECT_NEAR(scene.points[k].inverse_depth / truth.points[k].inverse_depth, 1, 1e-6);
  EXPECT_EQ(scene.poses[0].t, truth.poses[0].t);
  EXPECT_EQ(scene.poses[1].R, truth.poses[1].R);
}

/// A young segment: one pose and the length of the first baseline hold the gauge.
TEST(InverseDepthSolver, FindsTheTruthBesideAHeldLength) {
  Scene truth;
  truth.poses[0].held = true;
  truth.poses[1].length_held = true;
  ASSERT_LT(truth.poses[0].t.norm(), 1e-12);
  Scene scene = truth;
  scene.disturb(0.02, 0.5, 0.05);
  ASSERT_TRUE(solveInverseDepths(scene.poses, scene.points, 0.01));
  EXPECT_NEAR(scene.poses[1].t.norm(), truth.poses[1].t.norm(), 1e-9);
  EXPECT_LT(worstPosition(scene, truth), 1e-5);
}

/// One sighting in thirty is wrong by far: the sum is robust, the truth is found nearly.
TEST(InverseDepthSolver, WrongSightingsPullLittle) {
  const double noise = 3e-4;
  Scene truth;
  truth.poses[0].held = truth.poses[1].held = true;
  Scene scene(noise);
  scene.poses = truth.poses;
  for (std::size_t k = 0; k < scene.points.size(); k += 6)
    scene.points[k].sightings[k % 5].normalized += Eigen::Vector2d(0.05, 0.03);
  scene.disturb(0.01, 0.3, 0.03);
  ASSERT_TRUE(solveInverseDepths(scene.poses, scene.points, 2 * noise));
  EXPECT_LT(worstPosition(scene, truth), 0.05);
}

TEST(InverseDepthSolver, RefusesAPointBehindACamera) {
  Scene scene;
  scene.points[3].inverse_depth = -2;
  const auto before = scene.poses[2].t;
  EXPECT_FALSE(solveInverseDepths(scene.poses, scene.points, 0.01));
  EXPECT_EQ(scene.poses[2].t, before);
  EXPECT_EQ(scene.points[3].inverse_depth, -2);
}

}  // namespace
}  // namespace cf
