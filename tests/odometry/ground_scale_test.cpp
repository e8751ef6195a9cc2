// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "ground_scale.h"

#include <gtest/gtest.h>

#include <random>

namespace cf {
namespace {

constexpr double kUnits = 3.7;  ///< of the known depths per unit of the measured ones

struct Ground {
  double houses = 0;  ///< share of the points, a tenth nearer
  double relief = 0;  ///< standard deviation of the inverse depth, relative
  double wrong = 0;   ///< share of the points
};

/// The half of the photo above or below its middle, over a plane that is tilted.
std::vector<GroundSight> half(const Ground& ground, bool above, double units, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::normal_distribution<double> normal;
  std::vector<GroundSight> sights;
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector2d x(1.4 * uniform(random) - 0.7, (above ? -0.5 : 0.5) * uniform(random));
    double inverse = (1 + 0.1 * x.x() - 0.2 * x.y()) / 40;
    if (uniform(random) < ground.houses) inverse *= 1.1;
    inverse *= 1 + ground.relief * normal(random);
    if (uniform(random) < ground.wrong) inverse *= 3 * uniform(random);
    sights.push_back({x, inverse / units});
  }
  return sights;
}

double errorOf(const Ground& ground, unsigned seed) {
  const auto scale =
      scaleByGround(half(ground, true, 1, seed), half(ground, false, 1 / kUnits, seed + 1));
  EXPECT_TRUE(scale.ok());
  return scale ? *scale / kUnits - 1 : 1;
}

TEST(ScaleByGround, OfAPlaneIsExact) { EXPECT_NEAR(errorOf({}, 1), 0, 1e-9); }

TEST(ScaleByGround, HousesReliefAndWrongDepthsDisturbLittle) {
  for (unsigned seed = 1; seed < 20; ++seed)
    EXPECT_NEAR(errorOf({0.2, 0.01, 0.1}, seed), 0, 0.02) << seed;
}

TEST(ScaleByGround, RefusesWhatIsNoGround) {
  EXPECT_EQ(
      scaleByGround(half({0, 0.3, 0}, true, 1, 1), half({0, 0.3, 0}, false, 1, 2)).failure().code,
      "rough_ground");
  std::vector<GroundSight> few = half({}, true, 1, 1);
  few.resize(10);
  EXPECT_EQ(scaleByGround(few, half({}, false, 1, 2)).failure().code, "few_depths");
}

}  // namespace
}  // namespace cf
