// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/align/pair_observation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace cf {
namespace {

constexpr double kDegree = M_PI / 180;

CameraModel camera() {
  CameraModel c;
  c.width = 4000;
  c.height = 3000;
  c.fx = c.fy = 3000;
  c.cx = 2010;
  c.cy = 1490;
  c.k1 = -0.05;
  c.k2 = 0.01;
  return c;
}

Eigen::Isometry3d cameraPose(const Eigen::Vector3d& centre, double yaw_deg, double pitch_deg) {
  Eigen::Matrix3d nadir;
  nadir << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(yaw_deg * kDegree, Eigen::Vector3d::UnitZ()) * nadir *
               Eigen::AngleAxisd(pitch_deg * kDegree, Eigen::Vector3d::UnitX());
  T.translation() = centre;
  return T;
}

struct SceneOptions {
  double yaw_deg = 0, pitch_deg = 0;
  Eigen::Vector3d baseline{25, 15, 5};
  double buildings = 0;  ///< share of the points on roofs of 3 to 20 m
  double noise_px = 0.5;
  double outliers = 0.3;
  double depth_noise = 0.01;
  double with_depth = 0.6;
  int matches = 400;
};

/// Photo a in a segment of 40 m per VO unit, photo b in one of 7.
struct Scene {
  Keyframe a, b;
  std::vector<FeatureMatch> matches;
  Eigen::Isometry3d T_w_a, T_w_b;
  static constexpr double kScaleA = 40, kScaleB = 7;

  Scene(const SceneOptions& o, unsigned seed) {
    std::mt19937 rng(seed);
    std::normal_distribution<double> gauss;
    std::uniform_real_distribution<double> uniform(0, 1);
    T_w_a = cameraPose({0, 0, 100}, 20, o.pitch_deg);
    T_w_b = cameraPose(Eigen::Vector3d(0, 0, 100) + o.baseline, 20 + o.yaw_deg, o.pitch_deg / 2);
    a.id = {0, 4};
    b.id = {1, 7};
    b.segment = 2;
    a.camera = b.camera = camera();
    auto fa = std::make_shared<FeatureSet>(), fb = std::make_shared<FeatureSet>();
    const auto add = [&](Keyframe& k, FeatureSet& f, const Eigen::Vector2d& pixel, double depth_m,
                         double scale) {
      f.pixel.emplace_back(pixel.cast<float>());
      const double noisy = depth_m * (1 + o.depth_noise * gauss(rng));
      k.inverse_depth.push_back(uniform(rng) < o.with_depth ? static_cast<float>(scale / noisy)
                                                            : 0.f);
    };
    while (static_cast<int>(matches.size()) < o.matches) {
      const double height = uniform(rng) < o.buildings ? 3 + 17 * uniform(rng) : 0;
      const Eigen::Vector3d p(300 * uniform(rng) - 150, 300 * uniform(rng) - 150, height);
      const Eigen::Vector3d in_a = T_w_a.inverse() * p, in_b = T_w_b.inverse() * p;
      const Eigen::Vector2d pa = a.camera.project(in_a), pb = b.camera.project(in_b);
      if (!a.camera.contains(pa) || !b.camera.contains(pb)) continue;
      const auto noise = [&] {
        return Eigen::Vector2d(o.noise_px * gauss(rng), o.noise_px * gauss(rng));
      };
      const int i = static_cast<int>(fa->size());
      add(a, *fa, pa + noise(), in_a.z(), kScaleA);
      const bool outlier = uniform(rng) < o.outliers;
      add(b, *fb,
          outlier ? Eigen::Vector2d(3999 * uniform(rng), 2999 * uniform(rng)) : pb + noise(),
          in_b.z(), kScaleB);
      matches.push_back({i, i});
    }
    a.features = fa;
    b.features = fb;
  }

  Eigen::Isometry3d truth() const { return T_w_a.inverse() * T_w_b; }

  /// The segments' poses: 3 m and 2 degrees wrong.
  PairView viewA() const { return {&a, wrong(T_w_a, 1), kScaleA, 0.01 * kScaleA, true}; }
  PairView viewB() const { return {&b, wrong(T_w_b, -1), kScaleB, 0.01 * kScaleB, true}; }
  static Eigen::Isometry3d wrong(Eigen::Isometry3d T, double sign) {
    T.translation() += sign * Eigen::Vector3d(1, 2, 2);
    T.linear() =
        (Eigen::AngleAxisd(2 * sign * kDegree, Eigen::Vector3d(1, 2, -1).normalized()) * T.linear())
            .eval();
    return T;
  }
};

double rotationErrorDeg(const Eigen::Isometry3d& p, const Eigen::Isometry3d& q) {
  return Eigen::AngleAxisd(Eigen::Matrix3d(p.linear().transpose() * q.linear())).angle() / kDegree;
}

double directionErrorDeg(const Eigen::Isometry3d& p, const Eigen::Isometry3d& q) {
  const Eigen::Vector3d u = p.translation(), v = q.translation();
  return std::atan2(u.cross(v).norm(), u.dot(v)) / kDegree;
}

double lengthError(const Eigen::Isometry3d& p, const Eigen::Isometry3d& q) {
  return std::abs(p.translation().norm() / q.translation().norm() - 1);
}

TEST(PairObservation, PlanarSceneGivesAMetricPose) {
  for (const double yaw : {0.0, 90.0, 180.0}) {
    for (const double pitch : {0.0, 16.0}) {
      for (unsigned seed = 0; seed < 50; ++seed) {
        SceneOptions o;
        o.yaw_deg = yaw;
        o.pitch_deg = pitch;
        const Scene scene(o, seed);
        const auto seen = observePair(scene.viewA(), scene.viewB(), scene.matches, {});
        ASSERT_TRUE(seen.ok()) << seen.failure().detail;
        EXPECT_EQ(seen->model, PairModel::kHomography);
        EXPECT_LT(rotationErrorDeg(seen->pose.T_a_b, scene.truth()), 0.1);
        EXPECT_LT(directionErrorDeg(seen->pose.T_a_b, scene.truth()), 1);
        EXPECT_LT(lengthError(seen->pose.T_a_b, scene.truth()), 0.01);
        EXPECT_EQ(seen->pose.a, scene.a.id);
        EXPECT_EQ(seen->pose.b, scene.b.id);
        EXPECT_EQ(seen->segment_b, 2);
      }
    }
  }
}

TEST(PairObservation, ReliefIsLeftToTheEssentialMatrix) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    SceneOptions o;
    o.yaw_deg = 90 * (seed % 4);
    o.buildings = 0.7;
    const Scene scene(o, seed);
    const auto seen = observePair(scene.viewA(), scene.viewB(), scene.matches, {});
    ASSERT_TRUE(seen.ok()) << seen.failure().detail;
    EXPECT_EQ(seen->model, PairModel::kEssential);
    EXPECT_LT(rotationErrorDeg(seen->pose.T_a_b, scene.truth()), 0.1);
    EXPECT_LT(directionErrorDeg(seen->pose.T_a_b, scene.truth()), 1);
    EXPECT_LT(lengthError(seen->pose.T_a_b, scene.truth()), 0.01);
  }
}

TEST(PairObservation, DepthsAlonePickTheSolution) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    SceneOptions o;
    o.yaw_deg = 90 * (seed % 4);
    o.pitch_deg = 16;
    const Scene scene(o, seed);
    // Segments that know nothing of the world: poses in their local frames.
    PairView a = scene.viewA(), b = scene.viewB();
    a.trusted = b.trusted = false;
    a.T_world_cam = b.T_world_cam = Eigen::Isometry3d::Identity();
    const auto seen = observePair(a, b, scene.matches, {});
    ASSERT_TRUE(seen.ok()) << seen.failure().detail;
    EXPECT_LT(rotationErrorDeg(seen->pose.T_a_b, scene.truth()), 0.1);
    EXPECT_LT(directionErrorDeg(seen->pose.T_a_b, scene.truth()), 1);
    EXPECT_EQ(seen->gnss_length_m, 0);
  }
}

TEST(PairObservation, EitherPhotosDepthsTellTheRelativeScale) {
  const Scene scene({}, 11);
  PairView b = scene.viewB();
  b.scale *= 1.03;
  const auto seen = observePair(scene.viewA(), b, scene.matches, {});
  ASSERT_TRUE(seen.ok());
  ASSERT_GT(seen->by_depth_a.sigma_m, 0);
  ASSERT_GT(seen->by_depth_b.sigma_m, 0);
  EXPECT_NEAR(seen->by_depth_b.length_m / seen->by_depth_a.length_m, 1.03, 0.005);
}

TEST(PairObservation, GnssRatioStandsInForMissingDepths) {
  SceneOptions o;
  o.with_depth = 0;
  const Scene scene(o, 1);
  const auto seen = observePair(scene.viewA(), scene.viewB(), scene.matches, {});
  ASSERT_TRUE(seen.ok()) << seen.failure().detail;
  const double predicted = predictRelativePose(scene.viewA().T_world_cam, scene.viewB().T_world_cam)
                               .translation()
                               .norm();
  EXPECT_NEAR(seen->pose.T_a_b.translation().norm(), predicted, 1e-9);
  EXPECT_EQ(seen->by_depth_a.sigma_m, 0);
  EXPECT_LT(directionErrorDeg(seen->pose.T_a_b, scene.truth()), 1);
  EXPECT_GT(seen->pose.sigma.head<3>().norm(), 0.3 * predicted);

  PairView a = scene.viewA(), b = scene.viewB();
  b.trusted = false;
  const auto unknown = observePair(a, b, scene.matches, {});
  ASSERT_FALSE(unknown.ok());
  EXPECT_TRUE(unknown.failure().code == "no_length" || unknown.failure().code == "ambiguous");
}

TEST(PairObservation, ContradictionToATrustedAttitudeIsRefused) {
  const Scene scene({}, 2);
  PairView b = scene.viewB();
  b.T_world_cam.linear() =
      (Eigen::AngleAxisd(60 * kDegree, Eigen::Vector3d::UnitZ()) * b.T_world_cam.linear()).eval();
  const auto seen = observePair(scene.viewA(), b, scene.matches, {});
  ASSERT_FALSE(seen.ok());
  EXPECT_EQ(seen.failure().code, "against_prior");
  b.trusted = false;
  EXPECT_TRUE(observePair(scene.viewA(), b, scene.matches, {}).ok());
}

TEST(PairObservation, FewOrUnrelatedMatchesAreRefused) {
  SceneOptions o;
  o.matches = 20;
  const Scene few(o, 3);
  EXPECT_EQ(observePair(few.viewA(), few.viewB(), few.matches, {}).failure().code, "few_matches");
  SceneOptions wild;
  wild.outliers = 1;
  const Scene unrelated(wild, 3);
  EXPECT_FALSE(observePair(unrelated.viewA(), unrelated.viewB(), unrelated.matches, {}).ok());
}

TEST(PairObservation, SigmasAreHonest) {
  for (const double buildings : {0.0, 0.7}) {
    double rotation = 0, across = 0, along = 0;
    const unsigned seeds = 40;
    for (unsigned seed = 0; seed < seeds; ++seed) {
      SceneOptions o;
      o.buildings = buildings;
      o.outliers = 0.1;
      o.yaw_deg = 90;
      const Scene scene(o, seed);
      PairOptions options;
      options.systematic = 0;
      PairView a = scene.viewA(), b = scene.viewB();
      a.scale_sigma = b.scale_sigma = 0;
      const auto seen = observePair(a, b, scene.matches, options);
      ASSERT_TRUE(seen.ok());
      const double angle = rotationErrorDeg(seen->pose.T_a_b, scene.truth()) * kDegree;
      rotation += std::pow(angle / seen->rotation_sigma_rad, 2) / 3 / seeds;
      const Eigen::Vector3d error = scene.truth().translation() - seen->pose.T_a_b.translation();
      const double e_along = seen->direction_a.dot(error);
      across +=
          (error.squaredNorm() - e_along * e_along) / std::pow(seen->across_sigma_m, 2) / 2 / seeds;
      along += std::pow(e_along / seen->by_depth_a.sigma_m, 2) / seeds;
    }
    // 1 is exact; the depth floor and the robust weights make the sigmas cautious.
    EXPECT_GT(rotation, 0.5) << buildings;
    EXPECT_LT(rotation, 1.6) << buildings;
    EXPECT_GT(across, 0.5) << buildings;
    EXPECT_LT(across, 1.6) << buildings;
    EXPECT_LT(along, 1.5) << buildings;
  }
}

/// Cameras that are wrong by what they say they may be: the poses are off by what they say, too.
TEST(PairObservation, SigmasKnowTheCamera) {
  for (const double buildings : {0.0, 0.7}) {
    double rotation = 0, translation = 0, narrow = 0;
    const unsigned seeds = 60;
    for (unsigned seed = 0; seed < seeds; ++seed) {
      SceneOptions o;
      o.buildings = buildings;
      o.outliers = 0.1;
      o.yaw_deg = 90;
      Scene scene(o, seed);
      std::mt19937 rng(1000 + seed);
      std::normal_distribution<double> gauss;
      CameraModel wrong = camera();
      wrong.focal_sigma = 0.01 * wrong.fx;
      wrong.k1_sigma = 0.02;
      wrong.fx = wrong.fy = wrong.fx + wrong.focal_sigma * gauss(rng);
      wrong.k1 += wrong.k1_sigma * gauss(rng);
      scene.a.camera = scene.b.camera = wrong;
      const auto seen = observePair(scene.viewA(), scene.viewB(), scene.matches, {});
      scene.a.camera.focal_sigma = scene.b.camera.focal_sigma = 0;
      scene.a.camera.k1_sigma = scene.b.camera.k1_sigma = 0;
      const auto sure = observePair(scene.viewA(), scene.viewB(), scene.matches, {});
      ASSERT_TRUE(seen.ok() && sure.ok());
      EXPECT_TRUE(seen->pose.T_a_b.isApprox(sure->pose.T_a_b)) << "only the sigmas differ";
      const Eigen::AngleAxisd turn(
          Eigen::Matrix3d(seen->pose.T_a_b.linear() * scene.truth().linear().transpose()));
      const auto squares = [](const Eigen::Vector3d& error, const Eigen::Vector3d& sigma) {
        return error.cwiseQuotient(sigma).squaredNorm() / 3 / seeds;
      };
      rotation += squares(turn.angle() * turn.axis(), seen->pose.sigma.tail<3>());
      translation += squares(seen->pose.T_a_b.translation() - scene.truth().translation(),
                             seen->pose.sigma.head<3>());
      narrow += squares(turn.angle() * turn.axis(), sure->pose.sigma.tail<3>());
    }
    RecordProperty("nees_" + std::to_string(buildings), std::to_string(rotation) + " " +
                                                            std::to_string(translation) + " " +
                                                            std::to_string(narrow));
    EXPECT_GT(rotation, 0.4) << buildings;
    EXPECT_LT(rotation, 1.6) << buildings;
    EXPECT_GT(translation, 0.2) << buildings;
    EXPECT_LT(translation, 1.6) << buildings;
    EXPECT_GT(narrow, 3) << buildings << ": the camera matters";
  }
}

}  // namespace
}  // namespace cf
