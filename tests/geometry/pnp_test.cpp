// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/geometry/pnp.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

#include "support/views.h"

namespace cf {
namespace {

using support::nadirPose;
using support::quantile;
using support::rotationErrorDeg;

struct Scene {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector2d> seen;
  std::vector<char> outlier;
  Eigen::Isometry3d T_world_cam;

  /// A camera 80 m above ground far from the world's origin; noise on the normalized plane.
  Scene(double relief_sigma_m, double noise, double outliers, int count, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> gauss;
    std::uniform_real_distribution<double> uniform(-1, 1);
    const Eigen::Vector3d centre(4000, -2500, 380);
    const double yaw = 180 * uniform(random), pitch = 8 * gauss(random), roll = 4 * gauss(random);
    T_world_cam = nadirPose(centre, yaw, pitch, roll);
    while (static_cast<int>(points.size()) < count) {
      const double x = 90 * uniform(random), y = 90 * uniform(random);
      const Eigen::Vector3d p =
          centre + Eigen::Vector3d(x, y, -80 + relief_sigma_m * gauss(random));
      const Eigen::Vector3d in_cam = T_world_cam.inverse() * p;
      if (in_cam.z() <= 0) continue;
      const Eigen::Vector2d n = in_cam.hnormalized();
      if (std::abs(n.x()) > 2. / 3 || std::abs(n.y()) > 0.5) continue;
      points.push_back(p);
      outlier.push_back(0.5 * (1 + uniform(random)) < outliers);
      const double u = noise * gauss(random), v = noise * gauss(random);
      const double wrong_u = 0.66 * uniform(random), wrong_v = 0.5 * uniform(random);
      seen.push_back(outlier.back() ? Eigen::Vector2d(wrong_u, wrong_v)
                                    : Eigen::Vector2d(n + Eigen::Vector2d(u, v)));
    }
  }
};

class Resection : public testing::TestWithParam<double> {};

TEST_P(Resection, BearsNoiseAndOutliers) {
  std::vector<double> rotation, position;
  for (unsigned seed = 0; seed < 100; ++seed) {
    const Scene scene(GetParam(), 1. / 3000, 0.3, 200, seed);
    const auto pose = resect(scene.points, scene.seen, {});
    ASSERT_TRUE(pose.ok()) << pose.failure().detail;
    rotation.push_back(rotationErrorDeg(pose->T_world_cam, scene.T_world_cam));
    position.push_back((pose->T_world_cam.translation() - scene.T_world_cam.translation()).norm());
    int wrong = 0, counted = 0;
    for (std::size_t i = 0; i < scene.points.size(); ++i) {
      if (!scene.outlier[i]) {
        EXPECT_TRUE(pose->inlier[i]);
      }
      wrong += pose->inlier[i] && scene.outlier[i];
      counted += pose->inlier[i] != 0;
    }
    EXPECT_EQ(pose->inliers, counted);
    EXPECT_LE(wrong, 2);
  }
  const std::string figures = "rotation " + std::to_string(quantile(rotation, 0.5)) + " / " +
                              std::to_string(quantile(rotation, 1)) + " deg, position " +
                              std::to_string(quantile(position, 0.5)) + " / " +
                              std::to_string(quantile(position, 1)) + " m";
  RecordProperty("figures", figures);
  EXPECT_LT(quantile(rotation, 0.5), 0.02) << figures;
  EXPECT_LT(quantile(rotation, 1), 0.06) << figures;
  EXPECT_LT(quantile(position, 0.5), 0.03) << figures;
  EXPECT_LT(quantile(position, 1), 0.08) << figures;
}

TEST_P(Resection, IsExactWithoutNoise) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Scene scene(GetParam(), 0, 0.3, 100, seed);
    const auto pose = resect(scene.points, scene.seen, {});
    ASSERT_TRUE(pose.ok());
    // An outlier that lies within the threshold by chance pulls a little: judge scenes without.
    if (pose->inliers > std::count(scene.outlier.begin(), scene.outlier.end(), 0)) continue;
    EXPECT_LT(rotationErrorDeg(pose->T_world_cam, scene.T_world_cam), 1e-5);
    EXPECT_LT((pose->T_world_cam.translation() - scene.T_world_cam.translation()).norm(), 1e-5);
  }
}

/// Sigma of the relief [m]: exactly planar, and hilly.
INSTANTIATE_TEST_SUITE_P(Relief, Resection, testing::Values(0.0, 8.0));

TEST(Resection, TooFewOrUnrelatedPointsAreAFailure) {
  for (const int count : {0, 3, 14}) {
    const Scene few(5, 0, 0, count, 1);
    const auto pose = resect(few.points, few.seen, {});
    ASSERT_FALSE(pose.ok()) << count;
    EXPECT_EQ(pose.failure().code, "too_few_inliers");
  }
  const Scene unrelated(5, 0, 1, 100, 1);
  const auto pose = resect(unrelated.points, unrelated.seen, {});
  ASSERT_FALSE(pose.ok());
  EXPECT_EQ(pose.failure().code, "too_few_inliers");
}

TEST(Resection, IsDeterministic) {
  const Scene scene(0, 1. / 3000, 0.4, 150, 9);
  const auto p = resect(scene.points, scene.seen, {}), q = resect(scene.points, scene.seen, {});
  ASSERT_TRUE(p.ok() && q.ok());
  EXPECT_EQ(p->T_world_cam.matrix(), q->T_world_cam.matrix());
}

}  // namespace
}  // namespace cf
