// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/evaluate/registration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace cf {
namespace {

using Points = std::vector<Eigen::Vector3f>;

/// Rolling ground with houses, 80 m x 60 m, sampled at random.
Points village(unsigned seed, std::size_t count, double noise_m) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> x(0, 80), y(0, 60);
  std::normal_distribution<double> noise(0, noise_m);
  const auto height = [](double px, double py) {
    double z = 1.5 * std::sin(px / 9) + std::cos(py / 7 + px / 30);
    const double houses[4][4] = {{10, 12, 9, 6}, {35, 40, 7, 10}, {60, 20, 12, 8}, {55, 48, 6, 6}};
    for (const auto& h : houses) {
      const double u = px - h[0], v = py - h[1];
      if (u > 0 && u < h[2] && v > 0 && v < h[3])
        z += 4 + 0.6 * (h[2] / 2 - std::abs(u - h[2] / 2));
    }
    return z;
  };
  Points points;
  for (std::size_t i = 0; i < count; ++i) {
    const double px = x(random), py = y(random);
    points.emplace_back(static_cast<float>(px), static_cast<float>(py),
                        static_cast<float>(height(px, py) + noise(random)));
  }
  return points;
}

Eigen::Isometry3d motion(const Eigen::Vector3d& shift, const Eigen::Vector3d& turn_deg) {
  const Eigen::Vector3d middle(40, 30, 0), turn = turn_deg * M_PI / 180;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translate(middle + shift);
  if (turn.norm() > 0) T.rotate(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
  T.translate(-middle);
  return T;
}

void expectRecovered(Points estimate, const Points& reference, const Eigen::Isometry3d& T) {
  for (Eigen::Vector3f& p : estimate) p = (T.inverse() * p.cast<double>()).cast<float>();
  const auto result = registerClouds(estimate, reference);
  ASSERT_TRUE(result.ok()) << result.failure().detail;
  const Eigen::Isometry3d error = result->T_ref_est * T.inverse();
  const Eigen::Vector3d middle(40, 30, 0);
  EXPECT_LT((error * middle - middle).norm(), 0.03);
  EXPECT_LT(Eigen::AngleAxisd(error.linear()).angle() * 180 / M_PI, 0.1);
  EXPECT_NEAR(result->rotation_deg, Eigen::AngleAxisd(T.linear()).angle() * 180 / M_PI, 0.1);
}

TEST(Registration, MetresAndDegreesAreRecovered) {
  const Points reference = village(1, 60'000, 0.02), estimate = village(2, 40'000, 0.05);
  expectRecovered(estimate, reference, motion({0, 0, 0}, {0, 0, 0}));
  expectRecovered(estimate, reference, motion({3, -2, 1}, {1, -1, 2}));
  expectRecovered(estimate, reference, motion({-8, 9, -10}, {-1.5, 1, -2}));
  expectRecovered(estimate, reference, motion({0, 0, 60}, {0, 0, 0}));
}

TEST(Registration, OutliersAndHalfTheGround) {
  const Points reference = village(3, 60'000, 0.02);
  Points estimate;
  std::mt19937 random(4);
  std::uniform_real_distribution<float> up(0, 12);
  for (Eigen::Vector3f p : village(5, 60'000, 0.05)) {
    if (p.x() < 30) continue;
    if (random() % 5 == 0) p.z() += up(random);
    estimate.push_back(p);
  }
  expectRecovered(estimate, reference, motion({4, -3, 6}, {1, 0.5, -1}));
}

TEST(Registration, TheSameTwice) {
  const Points reference = village(6, 20'000, 0.02);
  Points estimate = village(7, 20'000, 0.05);
  for (Eigen::Vector3f& p : estimate) p += Eigen::Vector3f(2, 3, 4);
  const auto a = registerClouds(estimate, reference), b = registerClouds(estimate, reference);
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(a->T_ref_est.matrix(), b->T_ref_est.matrix());
}

TEST(Registration, FarApartIsAFailure) {
  Points estimate = village(8, 5'000, 0.02);
  for (Eigen::Vector3f& p : estimate) p.x() += 500;
  const auto result = registerClouds(estimate, village(9, 5'000, 0.02));
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.failure().code, "no_overlap");
}

}  // namespace
}  // namespace cf
