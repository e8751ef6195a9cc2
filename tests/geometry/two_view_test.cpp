// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/geometry/two_view.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

#include "support/views.h"

namespace cf {
namespace {

using support::angleDeg;
using support::nadirPose;
using support::quantile;
using support::rotationErrorDeg;

struct SceneOptions {
  double yaw_deg = 0;  ///< of b against a
  double relief_sigma_m = 0;
  Eigen::Vector3d baseline{25, 15, 5};
  double tilt_deg = 3;       ///< sigma of either camera's pitch and roll
  double noise = 1. / 3000;  ///< per coordinate in both photos, normalized plane
  double outliers = 0.3;
  int matches = 300;
};

/// Two photos from about 100 m, 4000 x 3000 px with a focal length of 3000.
struct Scene {
  std::vector<Eigen::Vector2d> a, b;
  std::vector<char> outlier;
  std::vector<Eigen::Vector3d> point_a;
  Eigen::Isometry3d T_a_b;

  Scene(const SceneOptions& o, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> gauss;
    std::uniform_real_distribution<double> uniform(-1, 1);
    const auto pose = [&](const Eigen::Vector3d& centre, double yaw) {
      const double pitch = o.tilt_deg * gauss(random), roll = o.tilt_deg * gauss(random);
      return nadirPose(centre, yaw, pitch, roll);
    };
    const auto T_w_a = pose({0, 0, 100}, 20);
    const auto T_w_b = pose(Eigen::Vector3d(0, 0, 100) + o.baseline, 20 + o.yaw_deg);
    T_a_b = T_w_a.inverse() * T_w_b;
    const auto seen = [](const Eigen::Vector3d& p) {
      return p.z() > 0 && std::abs(p.x() / p.z()) < 2. / 3 && std::abs(p.y() / p.z()) < 0.5;
    };
    const auto noise = [&] {
      const double x = o.noise * gauss(random), y = o.noise * gauss(random);
      return Eigen::Vector2d(x, y);
    };
    while (static_cast<int>(a.size()) < o.matches) {
      const double x = 150 * uniform(random), y = 150 * uniform(random);
      const Eigen::Vector3d p(x, y, o.relief_sigma_m * gauss(random));
      const Eigen::Vector3d in_a = T_w_a.inverse() * p, in_b = T_w_b.inverse() * p;
      if (!seen(in_a) || !seen(in_b)) continue;
      a.push_back(in_a.hnormalized() + noise());
      point_a.push_back(in_a);
      outlier.push_back(0.5 * (1 + uniform(random)) < o.outliers);
      const double u = 0.66 * uniform(random), v = 0.5 * uniform(random);
      b.push_back(outlier.back() ? Eigen::Vector2d(u, v)
                                 : Eigen::Vector2d(in_b.hnormalized() + noise()));
    }
  }
};

struct Case {
  const char* name;
  double relief_sigma_m;
  double median_rotation_deg, worst_rotation_deg, median_direction_deg, worst_direction_deg;
  bool planar;
};

class TwoViewOfScene : public testing::TestWithParam<Case> {};

TEST_P(TwoViewOfScene, IsRecoveredForEveryYaw) {
  const Case c = GetParam();
  std::vector<double> rotation, direction;
  for (const double yaw : {0.0, 90.0, 180.0, -37.0}) {
    for (unsigned seed = 0; seed < 25; ++seed) {
      SceneOptions o;
      o.yaw_deg = yaw;
      o.relief_sigma_m = c.relief_sigma_m;
      const Scene scene(o, seed);
      const auto view = estimateTwoView(scene.a, scene.b, {});
      ASSERT_TRUE(view.ok()) << view.failure().detail << " yaw " << yaw << " seed " << seed;
      rotation.push_back(rotationErrorDeg(view->T_a_b, scene.T_a_b));
      direction.push_back(angleDeg(view->T_a_b.translation(), scene.T_a_b.translation()));
      EXPECT_NEAR(view->T_a_b.translation().norm(), 1, 1e-9);
      EXPECT_EQ(view->planar, c.planar) << "yaw " << yaw << " seed " << seed;
      EXPECT_NEAR(view->median_parallax_rad, 0.27, 0.1);
      int kept = 0, good = 0, wrong = 0;
      for (std::size_t i = 0; i < scene.a.size(); ++i) {
        good += !scene.outlier[i];
        kept += view->inlier[i] && !scene.outlier[i];
        wrong += view->inlier[i] && scene.outlier[i];
        if (!view->inlier[i]) {
          EXPECT_EQ(view->point_a[i], Eigen::Vector3d(0, 0, 0));
        }
      }
      EXPECT_GT(kept, 0.95 * good);
      EXPECT_LT(wrong, 0.03 * static_cast<double>(scene.a.size()));
    }
  }
  const std::string figures = "rotation " + std::to_string(quantile(rotation, 0.5)) + " / " +
                              std::to_string(quantile(rotation, 1)) + ", direction " +
                              std::to_string(quantile(direction, 0.5)) + " / " +
                              std::to_string(quantile(direction, 1));
  RecordProperty("figures", figures);
  EXPECT_LT(quantile(rotation, 0.5), c.median_rotation_deg) << figures;
  EXPECT_LT(quantile(rotation, 1), c.worst_rotation_deg) << figures;
  EXPECT_LT(quantile(direction, 0.5), c.median_direction_deg) << figures;
  EXPECT_LT(quantile(direction, 1), c.worst_direction_deg) << figures;
}

// Measured times about 1.5 to 2: medians and worst of 100 scenes [deg].
INSTANTIATE_TEST_SUITE_P(Scenes, TwoViewOfScene,
                         testing::Values(Case{"relief", 10, 0.06, 0.25, 0.15, 0.9, false},
                                         Case{"plane", 0, 0.1, 0.5, 0.35, 1.8, true}),
                         [](const auto& c) { return std::string(c.param.name); });

TEST(TwoView, IsExactWithoutNoise) {
  for (const double relief : {0.0, 10.0}) {
    SceneOptions o;
    o.noise = 0;
    o.outliers = 0;
    o.yaw_deg = 90;
    o.relief_sigma_m = relief;
    const Scene scene(o, 7);
    const auto view = estimateTwoView(scene.a, scene.b, {});
    ASSERT_TRUE(view.ok());
    EXPECT_LT(rotationErrorDeg(view->T_a_b, scene.T_a_b), 1e-3);
    EXPECT_LT(angleDeg(view->T_a_b.translation(), scene.T_a_b.translation()), 1e-3);
    EXPECT_EQ(view->inliers, 300);
    const double baseline = scene.T_a_b.translation().norm();
    for (std::size_t i = 0; i < scene.a.size(); ++i)
      EXPECT_LT((baseline * view->point_a[i] - scene.point_a[i]).norm(), 0.01);
  }
}

TEST(TwoView, TooLittleParallaxIsAFailure) {
  for (const double relief : {0.0, 10.0}) {
    for (unsigned seed = 0; seed < 10; ++seed) {
      SceneOptions o;
      o.baseline = {0.3, 0.2, 0};  // 0.2 degrees seen from the ground
      o.relief_sigma_m = relief;
      const Scene scene(o, seed);
      const auto view = estimateTwoView(scene.a, scene.b, {});
      ASSERT_FALSE(view.ok()) << seed;
      EXPECT_EQ(view.failure().code, "too_little_parallax") << seed << view.failure().detail;
    }
  }
}

TEST(TwoView, TooFewMatchesIsAFailure) {
  SceneOptions o;
  o.outliers = 0;
  for (const int matches : {0, 1, 4, 7, 19}) {
    o.matches = matches;
    const Scene scene(o, 1);
    const auto view = estimateTwoView(scene.a, scene.b, {});
    ASSERT_FALSE(view.ok()) << matches;
    EXPECT_EQ(view.failure().code, "too_few_inliers");
  }
  o.matches = 40;
  const Scene scene(o, 1);
  EXPECT_TRUE(estimateTwoView(scene.a, scene.b, {}).ok());
}

TEST(TwoView, UnrelatedPhotosAreRefused) {
  SceneOptions o;
  o.outliers = 1;
  for (unsigned seed = 0; seed < 10; ++seed) {
    const Scene scene(o, seed);
    TwoViewOptions options;
    options.min_inliers = 60;  // of 300: epipolar lines of chance catch some
    const auto view = estimateTwoView(scene.a, scene.b, options);
    ASSERT_FALSE(view.ok()) << seed << " " << view->inliers;
    EXPECT_EQ(view.failure().code, "too_few_inliers");
  }
}

TEST(TwoView, IsDeterministic) {
  const Scene scene({}, 5);
  const auto p = estimateTwoView(scene.a, scene.b, {});
  const auto q = estimateTwoView(scene.a, scene.b, {});
  ASSERT_TRUE(p.ok() && q.ok());
  EXPECT_EQ(p->T_a_b.matrix(), q->T_a_b.matrix());
  EXPECT_EQ(p->inlier, q->inlier);
}

TEST(ConsistentMatches, KeepsTheTrueOnes) {
  for (const double relief : {0.0, 10.0}) {
    for (unsigned seed = 0; seed < 20; ++seed) {
      SceneOptions o;
      o.relief_sigma_m = relief;
      o.yaw_deg = 90 * (seed % 4);
      const Scene scene(o, seed);
      const auto keep = consistentMatches(scene.a, scene.b, 3. / 3000);
      ASSERT_EQ(keep.size(), scene.a.size());
      int kept = 0, good = 0, wrong = 0;
      for (std::size_t i = 0; i < keep.size(); ++i) {
        good += !scene.outlier[i];
        kept += keep[i] && !scene.outlier[i];
        wrong += keep[i] && scene.outlier[i];
      }
      // OpenCV judges an essential matrix by both epipolar distances together, which here keeps
      // 1.5 sigmas of noise, 87 % (measured 0.74 to 0.9); a homography all.
      EXPECT_GT(kept, (relief > 0 ? 0.68 : 0.95) * good) << relief << " " << seed;
      EXPECT_LT(wrong, 0.03 * static_cast<double>(keep.size())) << relief << " " << seed;
    }
  }
  EXPECT_EQ(consistentMatches({}, {}, 1e-3).size(), 0u);
}

}  // namespace
}  // namespace cf
