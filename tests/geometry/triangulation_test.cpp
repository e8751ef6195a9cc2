// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/geometry/triangulation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "support/views.h"

namespace cf {
namespace {

using support::nadirPose;

Sight sightOf(const Eigen::Isometry3d& T_world_cam, const Eigen::Vector3d& p) {
  return {T_world_cam, Eigen::Vector3d(T_world_cam.inverse() * p).hnormalized()};
}

TEST(Triangulate, IsExactWithoutNoise) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int round = 0; round < 200; ++round) {
    const Eigen::Vector3d p(3000 + 40 * uniform(random), 40 * uniform(random), 5 * uniform(random));
    std::vector<Sight> sights;
    for (int i = 0; i < 2 + round % 4; ++i) {
      const double x = 3000 + 20 * uniform(random), y = 20 * i + 5 * uniform(random);
      sights.push_back(sightOf(nadirPose({x, y, 90}, 180 * uniform(random), 5), p));
    }
    const auto point = triangulate(sights);
    ASSERT_TRUE(point.ok());
    EXPECT_LT((point->position - p).norm(), 1e-6);
    EXPECT_LT(point->max_error, 1e-9);
    double angle = 0;
    for (const Sight& i : sights)
      for (const Sight& j : sights)
        angle =
            std::max(angle, support::kDegree * support::angleDeg(i.T_world_cam.translation() - p,
                                                                 j.T_world_cam.translation() - p));
    EXPECT_NEAR(point->max_angle_rad, angle, 1e-6);
  }
}

/// Baseline B, height H, noise s of every sight: sigma of the height H^2/B sqrt(2) s.
TEST(Triangulate, NoiseGivesTheErrorThatTheoryTells) {
  std::mt19937 random(2);
  std::normal_distribution<double> gauss(0, 1e-3);
  const Eigen::Vector3d p(15, 0, 0);
  double sum2 = 0, mean = 0;
  const int rounds = 2000;
  for (int round = 0; round < rounds; ++round) {
    std::vector<Sight> sights{sightOf(nadirPose({0, 0, 100}, 0), p),
                              sightOf(nadirPose({30, 0, 100}, 0), p)};
    double error = 0;
    for (Sight& s : sights) {
      const Eigen::Vector2d noise(gauss(random), gauss(random));
      s.normalized += noise;
      error = std::max(error, noise.norm());
    }
    const auto point = triangulate(sights);
    ASSERT_TRUE(point.ok());
    EXPECT_LT(point->max_error, 1.5 * error);
    sum2 += point->position.z() * point->position.z() / rounds;
    mean += point->position.z() / rounds;
  }
  const double sigma = 100. * 100 / 30 * std::sqrt(2) * 1e-3;  // 0.47 m
  EXPECT_NEAR(std::sqrt(sum2), sigma, 0.06 * sigma);
  EXPECT_NEAR(mean, 0, 4 * sigma / std::sqrt(rounds));
}

TEST(Triangulate, ReportsTheWorstSight) {
  const Eigen::Vector3d p(3, 4, 0);
  std::vector<Sight> sights;
  for (int i = 0; i < 8; ++i)
    sights.push_back(sightOf(nadirPose({10. * i - 35, 0, 100}, 45. * i), p));
  sights[3].normalized += Eigen::Vector2d(0.02, 0);
  const auto point = triangulate(sights);
  ASSERT_TRUE(point.ok());
  EXPECT_GT(point->max_error, 0.013);
  EXPECT_LT(point->max_error, 0.02);
  EXPECT_EQ(point->max_error, reprojectionError(sights[3], point->position));
}

TEST(Triangulate, FailsWithAReason) {
  const Eigen::Vector3d p(0, 0, 0);
  const Sight one = sightOf(nadirPose({0, 0, 100}, 0), p);
  EXPECT_EQ(triangulate({}).failure().code, "too_few_sights");
  EXPECT_EQ(triangulate({one}).failure().code, "too_few_sights");
  // The same ray from two heights.
  EXPECT_EQ(triangulate({one, sightOf(nadirPose({0, 0, 50}, 30), p)}).failure().code, "parallel");
  // The same direction from two places: the point is at infinity.
  Sight parallel = one;
  parallel.T_world_cam.translation().x() += 20;
  EXPECT_EQ(triangulate({one, parallel}).failure().code, "parallel");
  // Rays that part: they meet above the cameras.
  Sight left = one, right = one;
  left.normalized.x() = -0.1;
  right.normalized.x() = 0.1;
  right.T_world_cam.translation().x() += 20;
  EXPECT_EQ(triangulate({left, right}).failure().code, "behind");
}

TEST(ReprojectionError, IsTheDistanceOnTheNormalizedPlane) {
  const Sight sight{nadirPose({10, 20, 100}, 0), {0.1, -0.2}};
  // Depth 100: x = east / 100, y = -north / 100.
  EXPECT_NEAR(reprojectionError(sight, {20, 40, 0}), 0, 1e-12);
  EXPECT_NEAR(reprojectionError(sight, {23, 36, 0}), 0.05, 1e-12);
  EXPECT_EQ(reprojectionError(sight, {20, 40, 120}), std::numeric_limits<double>::infinity());
}

TEST(NormalizedPoints, UndoTheLens) {
  CameraModel camera;
  camera.width = 4000;
  camera.height = 3000;
  camera.fx = camera.fy = 2900;
  camera.cx = 2010;
  camera.cy = 1490;
  camera.k1 = -0.08;
  camera.k2 = 0.02;
  camera.p1 = 5e-4;
  const std::vector<Eigen::Vector2d> points{{0, 0}, {0.5, -0.3}, {-0.62, 0.44}};
  FeatureSet features;
  for (const auto& p : points) features.pixel.push_back(camera.distort(p).cast<float>());
  const auto normalized = normalizedPoints(features, camera);
  ASSERT_EQ(normalized.size(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_LT((normalized[i] - points[i]).norm(), 1e-7);
}

}  // namespace
}  // namespace cf
