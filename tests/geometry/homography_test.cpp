// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/geometry/homography.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "support/views.h"

namespace cf {
namespace {

using support::angleDeg;
using support::kDegree;
using support::nadirPose;
using support::rotationErrorDeg;

struct SceneOptions {
  double yaw_deg = 0;
  double pitch_deg = 0;
  Eigen::Vector3d baseline{25, 15, 5};
  double relief_sigma_m = 0;
  double noise = 0.5 / 3000;  ///< per coordinate in both photos, normalized plane
  double outliers = 0.3;
  int matches = 300;
};

/// Two photos from about 100 m above the plane z = 0, 4000 x 3000 px with a focal length of 3000.
struct Scene {
  std::vector<Eigen::Vector2d> a, b;
  std::vector<char> outlier;
  Eigen::Isometry3d T_a_b;
  Eigen::Vector3d normal_a;
  double distance = 0;  ///< of a to the plane

  Scene(const SceneOptions& o, unsigned seed) {
    std::mt19937 rng(seed);
    std::normal_distribution<double> gauss;
    std::uniform_real_distribution<double> uniform(-1, 1);
    const auto T_w_a = nadirPose({0, 0, 100}, 20, o.pitch_deg);
    const auto T_w_b =
        nadirPose(Eigen::Vector3d(0, 0, 100) + o.baseline, 20 + o.yaw_deg, o.pitch_deg / 2);
    T_a_b = T_w_a.inverse() * T_w_b;
    normal_a = T_w_a.linear().transpose() * Eigen::Vector3d(0, 0, -1);
    distance = 100;
    const auto seen = [](const Eigen::Vector3d& p) {
      return p.z() > 0 && std::abs(p.x() / p.z()) < 2. / 3 && std::abs(p.y() / p.z()) < 0.5;
    };
    while (static_cast<int>(a.size()) < o.matches) {
      const Eigen::Vector3d p(150 * uniform(rng), 150 * uniform(rng),
                              o.relief_sigma_m * gauss(rng));
      const Eigen::Vector3d in_a = T_w_a.inverse() * p, in_b = T_w_b.inverse() * p;
      if (!seen(in_a) || !seen(in_b)) continue;
      const auto noise = [&] {
        return Eigen::Vector2d(o.noise * gauss(rng), o.noise * gauss(rng));
      };
      a.push_back(in_a.hnormalized() + noise());
      outlier.push_back(0.5 * (1 + uniform(rng)) < o.outliers);
      b.push_back(outlier.back() ? Eigen::Vector2d(0.66 * uniform(rng), 0.5 * uniform(rng))
                                 : Eigen::Vector2d(in_b.hnormalized() + noise()));
    }
  }

  /// As a flight knows it: both a few degrees wrong.
  PlanePrior prior(unsigned seed) const {
    std::mt19937 rng(seed);
    std::normal_distribution<double> gauss(0, 3 * kDegree);
    const auto tilt = [&] {
      return Eigen::AngleAxisd(gauss(rng), Eigen::Vector3d::UnitX()) *
             Eigen::AngleAxisd(gauss(rng), Eigen::Vector3d::UnitY());
    };
    PlanePrior p;
    p.normal_a = tilt() * normal_a;
    p.R_a_b = T_a_b.linear() * tilt().toRotationMatrix();
    return p;
  }
};

TEST(Homography, RecoversThePoseForEveryYawAndPitch) {
  for (const double yaw : {0.0, 90.0, 180.0, 270.0, 37.0}) {
    for (const double pitch : {0.0, 16.0}) {
      double worst_rotation = 0, worst_direction = 0, worst_length = 0;
      for (unsigned seed = 0; seed < 60; ++seed) {
        SceneOptions o;
        o.yaw_deg = yaw;
        o.pitch_deg = pitch;
        const Scene scene(o, seed);
        const auto pose = estimatePlanarPose(scene.a, scene.b, scene.prior(seed), {});
        ASSERT_TRUE(pose.ok()) << pose.failure().detail;
        const Eigen::Isometry3d& T = pose->motion.T_a_b;
        worst_rotation = std::max(worst_rotation, rotationErrorDeg(T, scene.T_a_b));
        worst_direction =
            std::max(worst_direction, angleDeg(T.translation(), scene.T_a_b.translation()));
        worst_length = std::max(worst_length, std::abs(T.translation().norm() * scene.distance /
                                                           scene.T_a_b.translation().norm() -
                                                       1));
        EXPECT_LT(angleDeg(pose->motion.normal_a, scene.normal_a), 1);
        for (std::size_t i = 0; i < scene.a.size(); ++i) {
          if (!scene.outlier[i]) {
            EXPECT_TRUE(pose->inlier[i]);
          }
        }
        EXPECT_LT(pose->direction_sigma_rad / kDegree, 0.5);
      }
      EXPECT_LT(worst_rotation, 0.1) << "yaw " << yaw << " pitch " << pitch;
      EXPECT_LT(worst_direction, 1) << "yaw " << yaw << " pitch " << pitch;
      EXPECT_LT(worst_length, 0.02) << "yaw " << yaw << " pitch " << pitch;
    }
  }
}

TEST(Homography, IsExactWithoutNoise) {
  SceneOptions o;
  o.noise = 0;
  o.yaw_deg = 90;
  o.pitch_deg = 16;
  const Scene scene(o, 3);
  const auto pose = estimatePlanarPose(scene.a, scene.b, scene.prior(3), {});
  ASSERT_TRUE(pose.ok());
  EXPECT_LT(rotationErrorDeg(pose->motion.T_a_b, scene.T_a_b), 1e-5);
  EXPECT_LT((pose->motion.T_a_b.translation() - scene.T_a_b.translation() / 100).norm(), 1e-6);
}

TEST(Homography, EitherPriorAlonePicksTheRightOneOfTheFour) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    SceneOptions o;
    o.pitch_deg = seed % 2 == 0 ? 0 : 16;
    o.yaw_deg = 90 * (seed % 4);
    const Scene scene(o, seed);
    PlanePrior only_normal = scene.prior(seed), only_rotation = scene.prior(seed);
    only_normal.R_a_b.reset();
    only_rotation.normal_a.reset();
    for (const PlanePrior& prior : {only_normal, only_rotation}) {
      const auto pose = estimatePlanarPose(scene.a, scene.b, prior, {});
      ASSERT_TRUE(pose.ok());
      EXPECT_LT(rotationErrorDeg(pose->motion.T_a_b, scene.T_a_b), 0.1);
      // The rival explains the same photos with another plane: the prior is what decides.
      for (const PlaneMotion& rival : pose->alternatives) {
        EXPECT_GT(angleDeg(rival.normal_a, scene.normal_a), 5);
        EXPECT_GT(rival.prior_cost, pose->motion.prior_cost);
      }
    }
  }
}

TEST(Homography, BearsSomeRelief) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    SceneOptions o;
    o.relief_sigma_m = 0.3;
    o.pitch_deg = 16;
    o.yaw_deg = 90 * (seed % 4);
    const Scene scene(o, seed);
    const auto pose = estimatePlanarPose(scene.a, scene.b, scene.prior(seed), {});
    ASSERT_TRUE(pose.ok());
    EXPECT_LT(rotationErrorDeg(pose->motion.T_a_b, scene.T_a_b), 0.3);
    EXPECT_LT(angleDeg(pose->motion.T_a_b.translation(), scene.T_a_b.translation()), 2);
  }
}

/// The covariance must say how wrong the estimate is: normalised errors within chi-square bounds.
TEST(Homography, CovarianceIsHonest) {
  double rotation = 0, translation = 0;
  const int seeds = 200;
  for (unsigned seed = 0; seed < seeds; ++seed) {
    SceneOptions o;
    o.outliers = 0.1;
    o.pitch_deg = 8;
    o.yaw_deg = 90;
    const Scene scene(o, seed);
    const auto pose = estimatePlanarPose(scene.a, scene.b, scene.prior(seed), {});
    ASSERT_TRUE(pose.ok());
    const auto& T = pose->motion.T_a_b;
    const Eigen::AngleAxisd w(Eigen::Matrix3d(T.linear().transpose() * scene.T_a_b.linear()));
    const Eigen::Vector3d dw = w.angle() * w.axis();
    const Eigen::Vector3d dc = scene.T_a_b.translation() / 100 - T.translation();
    rotation += dw.dot(pose->covariance.block<3, 3>(3, 3).inverse() * dw) / 3 / seeds;
    translation += dc.dot(pose->covariance.block<3, 3>(0, 0).inverse() * dc) / 3 / seeds;
  }
  // 1 is exact (sigma of the mean 0.06); the robust weights make it up to a third cautious.
  EXPECT_GT(rotation, 0.6);
  EXPECT_LT(rotation, 1.2);
  EXPECT_GT(translation, 0.6);
  EXPECT_LT(translation, 1.2);
}

TEST(Homography, PureRotationIsFlagged) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    SceneOptions o;
    o.baseline = {0, 0, 0};
    o.yaw_deg = 90;
    const Scene scene(o, seed);
    const auto pose = estimatePlanarPose(scene.a, scene.b, scene.prior(seed), {});
    ASSERT_TRUE(pose.ok());
    EXPECT_LT(rotationErrorDeg(pose->motion.T_a_b, scene.T_a_b), 0.1);
    EXPECT_LT(pose->motion.T_a_b.translation().norm(), 0.005);
    EXPECT_GT(pose->direction_sigma_rad, 0.2);
  }
}

TEST(Homography, UnrelatedPhotosAreRefused) {
  std::mt19937 rng(1);
  std::uniform_real_distribution<double> uniform(-0.6, 0.6);
  std::vector<Eigen::Vector2d> a, b;
  for (int i = 0; i < 200; ++i) {
    a.emplace_back(uniform(rng), uniform(rng));
    b.emplace_back(uniform(rng), uniform(rng));
  }
  const auto pose = estimatePlanarPose(a, b, {}, {});
  ASSERT_FALSE(pose.ok());
  EXPECT_EQ(pose.failure().code, "too_few_inliers");
  EXPECT_FALSE(estimatePlanarPose({}, {}, {}, {}).ok());
}

TEST(Homography, IsDeterministic) {
  const Scene scene({}, 5);
  const auto p = estimatePlanarPose(scene.a, scene.b, scene.prior(5), {});
  const auto q = estimatePlanarPose(scene.a, scene.b, scene.prior(5), {});
  ASSERT_TRUE(p.ok() && q.ok());
  EXPECT_EQ(p->motion.T_a_b.matrix(), q->motion.T_a_b.matrix());
  EXPECT_EQ(p->covariance, q->covariance);
}

}  // namespace
}  // namespace cf
