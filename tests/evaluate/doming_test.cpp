// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/evaluate/doming.h"

#include <gtest/gtest.h>

namespace cf {
namespace {

TEST(Doming, IsTheQuadraticPartAlone) {
  std::vector<Eigen::Vector2d> places;
  std::vector<double> errors;
  for (int y = 0; y <= 20; ++y)
    for (int x = 0; x <= 20; ++x) {
      const Eigen::Vector2d p(500 + 10 * x, -300 + 10 * y), q = p - Eigen::Vector2d(600, -200);
      places.push_back(p);
      errors.push_back(7 + 0.01 * p.x() - 0.02 * p.y() + 1e-5 * q.squaredNorm());
    }
  const auto doming = domingOf(places, errors);
  ASSERT_TRUE(doming);
  EXPECT_NEAR(doming->span_m, 1e-5 * 2 * 100 * 100, 1e-9);
  EXPECT_FALSE(domingOf({5, Eigen::Vector2d(1, 2)}, std::vector<double>(5)));
  EXPECT_FALSE(domingOf({9, Eigen::Vector2d(1, 2)}, std::vector<double>(9)));
  const auto left = withoutBend(places, errors);
  ASSERT_TRUE(left);
  for (const double e : *left) EXPECT_NEAR(e, 0, 1e-9);
  errors[17] += 1;
  EXPECT_NEAR((*withoutBend(places, errors))[17], 1, 1e-6);
}

}  // namespace
}  // namespace cf
