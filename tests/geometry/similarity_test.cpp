// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/geometry/similarity.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "support/views.h"

namespace cf {
namespace {

using Points = std::vector<Eigen::Vector3d>;

struct Random {
  std::mt19937 engine;
  explicit Random(unsigned seed) : engine(seed) {}

  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  }
  Eigen::Vector3d normal3(double sigma) {
    std::normal_distribution<double> gauss(0, sigma);
    const double x = gauss(engine), y = gauss(engine), z = gauss(engine);
    return {x, y, z};
  }
  Sim3 similarity(AlignmentModel model) {
    Sim3 S;
    const double angle = uniform(-M_PI, M_PI);
    const Eigen::Vector3d axis =
        model == AlignmentModel::kYaw4 ? Eigen::Vector3d::UnitZ() : normal3(1).normalized();
    S.rotation = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
    if (model == AlignmentModel::kSim3) S.scale = std::exp(uniform(-3, 3));
    S.translation = normal3(300);
    return S;
  }
  Points cloud(int count, const Eigen::Vector3d& extent) {
    Points points;
    for (int i = 0; i < count; ++i) points.push_back(normal3(1).cwiseProduct(extent));
    return points;
  }
};

Points mapped(const Sim3& S, const Points& points) {
  Points out;
  for (const auto& p : points) out.push_back(S * p);
  return out;
}

constexpr AlignmentModel kModels[] = {AlignmentModel::kSe3, AlignmentModel::kSim3,
                                      AlignmentModel::kYaw4};

TEST(AlignPoints, RecoversKnownTransforms) {
  for (const AlignmentModel model : kModels) {
    for (unsigned seed = 0; seed < 100; ++seed) {
      Random random(seed);
      const Sim3 truth = random.similarity(model);
      // Volumes, planes (a mirrored rotation would fit those as well), and the fewest points.
      const Eigen::Vector3d extent =
          seed % 3 == 0 ? Eigen::Vector3d(50, 30, 0) : Eigen::Vector3d(50, 30, 10);
      const int fewest = model == AlignmentModel::kYaw4 ? 2 : 3;
      const Points b = random.cloud(seed % 2 == 0 ? 40 : fewest, extent);
      const auto S = alignPoints(mapped(truth, b), b, model);
      ASSERT_TRUE(S.ok()) << S.failure().detail;
      EXPECT_LT((S->rotation - truth.rotation).norm(), 1e-8);
      EXPECT_NEAR(S->rotation.determinant(), 1, 1e-9);
      EXPECT_NEAR(S->scale / truth.scale, 1, 1e-9);
      EXPECT_LT((S->translation - truth.translation).norm(), 1e-7 * (1 + truth.scale));
    }
  }
}

TEST(AlignPoints, KeepsTheScaleThatTheModelFixes) {
  Random random(1);
  const Sim3 truth = {2.5, random.similarity(AlignmentModel::kYaw4).rotation, {3, 4, 5}};
  const Points b = random.cloud(30, {10, 10, 10}), a = mapped(truth, b);
  EXPECT_EQ(alignPoints(a, b, AlignmentModel::kSe3)->scale, 1);
  EXPECT_EQ(alignPoints(a, b, AlignmentModel::kYaw4)->scale, 1);
  EXPECT_NEAR(alignPoints(a, b, AlignmentModel::kSim3)->scale, 2.5, 1e-9);
}

/// Yaw alone can be told from a line; the least-squares yaw leaves a tilt where it is.
TEST(AlignPoints, YawOfALineAndOfATiltedSet) {
  Random random(2);
  Points line;
  for (int i = 0; i < 10; ++i) line.emplace_back(3. * i, 4. * i, 0);
  const Sim3 truth = random.similarity(AlignmentModel::kYaw4);
  const auto S = alignPoints(mapped(truth, line), line, AlignmentModel::kYaw4);
  ASSERT_TRUE(S.ok());
  EXPECT_LT((S->rotation - truth.rotation).norm(), 1e-9);
  const Points b = random.cloud(2000, {50, 50, 5});
  const Eigen::AngleAxisd tilt(0.1, Eigen::Vector3d::UnitX());
  const auto tilted =
      alignPoints(mapped({1, tilt.toRotationMatrix(), {0, 0, 0}}, b), b, AlignmentModel::kYaw4);
  ASSERT_TRUE(tilted.ok());
  EXPECT_LT((tilted->rotation.col(2) - Eigen::Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_LT(support::rotationErrorDeg(tilted->rotation, Eigen::Matrix3d::Identity()), 0.05);
}

TEST(AlignPoints, FailsWithAReason) {
  Points line;
  for (int i = 0; i < 10; ++i) line.emplace_back(3. * i + 100, 4. * i - 50, 2. * i);
  const Points same(5, Eigen::Vector3d(1, 2, 3)), two(line.begin(), line.begin() + 2);
  for (const AlignmentModel model : {AlignmentModel::kSe3, AlignmentModel::kSim3}) {
    EXPECT_EQ(alignPoints(line, line, model).failure().code, "collinear");
    EXPECT_EQ(alignPoints(same, same, model).failure().code, "collinear");
    EXPECT_EQ(alignPoints(two, two, model).failure().code, "too_few_points");
    EXPECT_EQ(alignPoints(line, two, model).failure().code, "too_few_points");
  }
  EXPECT_TRUE(alignPoints(two, two, AlignmentModel::kYaw4).ok());
  EXPECT_EQ(alignPoints({}, {}, AlignmentModel::kYaw4).failure().code, "too_few_points");
}

TEST(AlignPoints, WeightsCount) {
  Random random(3);
  const Sim3 truth = random.similarity(AlignmentModel::kSim3);
  Points b = random.cloud(20, {50, 30, 10}), a = mapped(truth, b);
  std::vector<double> weights(b.size(), 2);
  a[4] += Eigen::Vector3d(500, 0, 0);
  weights[4] = 0;
  const auto S = alignPoints(a, b, AlignmentModel::kSim3, weights);
  ASSERT_TRUE(S.ok());
  EXPECT_LT((S->rotation - truth.rotation).norm(), 1e-8);
  // A weight of 3 is the point given three times.
  weights.assign(b.size(), 1);
  weights[4] = 3;
  const auto weighted = alignPoints(a, b, AlignmentModel::kSim3, weights);
  for (int k = 0; k < 2; ++k) {
    a.push_back(a[4]);
    b.push_back(b[4]);
  }
  const auto repeated = alignPoints(a, b, AlignmentModel::kSim3);
  ASSERT_TRUE(weighted.ok() && repeated.ok());
  EXPECT_LT((weighted->rotation - repeated->rotation).norm(), 1e-9);
  EXPECT_NEAR(weighted->scale, repeated->scale, 1e-9);
}

TEST(AlignPointsRobust, BearsFortyPercentOutliers) {
  for (const AlignmentModel model : kModels) {
    for (unsigned seed = 0; seed < 20; ++seed) {
      Random random(seed);
      Sim3 truth = random.similarity(model);
      if (model == AlignmentModel::kSim3) truth.scale = random.uniform(0.2, 5);
      const Points b = random.cloud(150, {50, 30, 10});
      Points a = mapped(truth, b);
      std::vector<char> outlier(a.size(), 0);
      for (std::size_t i = 0; i < a.size(); ++i) {
        outlier[i] = i % 5 < 2;
        a[i] += outlier[i] ? random.normal3(60 * truth.scale) : random.normal3(0.1 * truth.scale);
      }
      const auto fit = alignPointsRobust(a, b, model, 0.5 * truth.scale, 20, 1);
      ASSERT_TRUE(fit.ok()) << fit.failure().detail;
      int kept = 0, wrong = 0;
      for (std::size_t i = 0; i < a.size(); ++i) {
        kept += fit->inlier[i] && !outlier[i];
        wrong += fit->inlier[i] && outlier[i];
      }
      EXPECT_GE(kept, 88) << seed;
      EXPECT_LE(wrong, 1) << seed;
      EXPECT_EQ(fit->inliers, kept + wrong);
      EXPECT_LT(support::rotationErrorDeg(fit->S_a_b.rotation, truth.rotation), 0.15) << seed;
      EXPECT_NEAR(fit->S_a_b.scale / truth.scale, 1, 0.003) << seed;
      const auto again = alignPointsRobust(a, b, model, 0.5 * truth.scale, 20, 1);
      EXPECT_EQ(again->S_a_b.rotation, fit->S_a_b.rotation);
      EXPECT_EQ(again->inlier, fit->inlier);
    }
  }
}

/// Of very many pairs a sample with an outlier agrees with a few by chance: it must not end the
/// search.
TEST(AlignPointsRobust, GoesOnAfterABadSampleOfManyPairs) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    Random random(seed);
    const Sim3 truth = random.similarity(AlignmentModel::kSim3);
    const Points b = random.cloud(5000, {50, 30, 10});
    Points a = mapped(truth, b);
    for (std::size_t i = 0; i < a.size(); ++i)
      if (i % 5 < 2) a[i] += random.normal3(60 * truth.scale);
    const auto fit =
        alignPointsRobust(a, b, AlignmentModel::kSim3, 3 * truth.scale, 2500, seed + 1);
    ASSERT_TRUE(fit.ok()) << seed << ": " << fit.failure().detail;
    EXPECT_NEAR(fit->inliers, 3000, 10) << seed;
  }
}

TEST(AlignPointsRobust, FailsWhereTooFewAgree) {
  Random random(5);
  const Points b = random.cloud(100, {50, 30, 10}), a = random.cloud(100, {50, 30, 10});
  const auto fit = alignPointsRobust(a, b, AlignmentModel::kSim3, 0.5, 20, 1);
  ASSERT_FALSE(fit.ok());
  EXPECT_EQ(fit.failure().code, "too_few_inliers");
  const Points few(b.begin(), b.begin() + 19);
  EXPECT_EQ(alignPointsRobust(few, few, AlignmentModel::kSim3, 0.5, 20, 1).failure().code,
            "too_few_points");
}

}  // namespace
}  // namespace cf
