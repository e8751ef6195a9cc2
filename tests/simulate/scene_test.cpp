// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/simulate/scene.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cf/base/error.h"

namespace cf {
namespace {

constexpr std::uint64_t kSeed = 5;

/// Away from the origin, as in a real world frame.
Eigen::AlignedBox2d area() { return {Eigen::Vector2d(900, -350), Eigen::Vector2d(1000, -250)}; }

SceneOptions bareGround() {
  SceneOptions options;
  options.terrain = "flat";
  options.building_density = options.tree_density = 0;
  return options;
}

TEST(Scene, FlatGroundIsHitExactly) {
  const Scene scene(bareGround(), area(), kSeed);
  const Eigen::Vector3d from(948.1, -301.7, 97.25);
  for (double dx = -0.4; dx <= 0.4; dx += 0.1) {
    for (double dy = -0.4; dy <= 0.4; dy += 0.1) {
      const auto hit = scene.hit(from, {dx, dy, -1});
      ASSERT_TRUE(hit);
      EXPECT_NEAR(hit->distance, 97.25, 1e-9);
      EXPECT_NEAR(hit->position_m.x(), from.x() + 97.25 * dx, 1e-9);
      EXPECT_EQ(hit->object, 0U);
      EXPECT_NEAR(hit->normal.z(), 1, 1e-12);
    }
  }
}

TEST(Scene, HillsHaveTheReliefAskedForAndAreHitWhereTheyAre) {
  SceneOptions options = bareGround();
  options.terrain = "hills";
  options.relief_m = 12;
  const Scene scene(options, area(), kSeed);
  double low = 1e9, high = -1e9;
  for (double x = 905; x < 1000; x += 5.3) {
    for (double y = -345; y < -250; y += 5.3) {
      const double ground = scene.groundHeight(x, y);
      EXPECT_NEAR(scene.surfaceHeight(x, y), ground, 1e-4);
      low = std::min(low, ground);
      high = std::max(high, ground);
    }
  }
  EXPECT_GE(low, 0);
  EXPECT_LE(high, 12);
  EXPECT_GT(high - low, 2);
}

TEST(Scene, ObliqueAndVerticalRaysMeetTheSameSurface) {
  const Scene scene({}, area(), kSeed);
  int raised = 0, compared = 0;
  for (double x = 910; x < 990; x += 3.1) {
    for (double y = -340; y < -260; y += 3.1) {
      const double top = scene.surfaceHeight(x, y);
      if (top > scene.groundHeight(x, y) + 2) ++raised;
      const Eigen::Vector3d point(x, y, top), from(955, -305, 160);
      const auto hit = scene.hit(from, point - from);
      ASSERT_TRUE(hit);
      EXPECT_LT(hit->distance, 1 + 1e-4);      // nothing behind the surface is seen
      if (hit->distance < 1 - 2e-5) continue;  // hidden from there
      EXPECT_LT((hit->position_m - point).norm(), 2e-3) << x << " " << y;
      ++compared;
    }
  }
  EXPECT_GT(raised, 50);
  EXPECT_GT(compared, 400);
}

TEST(Scene, ShadowsLieOnTheSideAwayFromTheSun) {
  SceneOptions options = bareGround();
  options.building_density = 20;
  options.crop_share = 0;
  options.sun_azimuth_deg = 90;  // in the east
  options.sun_elevation_deg = 35;
  const Scene scene(options, area(), kSeed);
  auto brightness = [&](double x, double y) {
    const auto hit = scene.hit({x, y, 200}, {0, 0, -1});
    return hit && hit->object == 0 ? scene.radiance(*hit, 5.0).sum() : -1;
  };
  double west = 0, east = 0;
  int pairs = 0;
  for (double y = -345; y < -255; y += 1) {
    for (double x = 905; x < 995; x += 0.5) {
      // From a roof to the first bare ground on either side of it.
      const bool enters = scene.surfaceHeight(x - 0.5, y) < 0.01 && scene.surfaceHeight(x, y) > 2;
      if (!enters) continue;
      double end = x;
      while (end < 995 && scene.surfaceHeight(end, y) > 0.01) end += 0.5;
      const float w = brightness(x - 1.2, y), e = brightness(end + 0.7, y);
      if (w < 0 || e < 0) continue;
      west += w;
      east += e;
      ++pairs;
    }
  }
  ASSERT_GT(pairs, 30);
  EXPECT_LT(west, 0.6 * east);
}

TEST(Scene, SeedDecidesAndNothingElse) {
  const Scene a({}, area(), 3), b({}, area(), 3), c({}, area(), 4);
  int other = 0;
  for (double x = 905; x < 995; x += 2) {
    const double y = -300 + 0.3 * (x - 950);
    EXPECT_EQ(a.surfaceHeight(x, y), b.surfaceHeight(x, y));
    if (std::abs(a.surfaceHeight(x, y) - c.surfaceHeight(x, y)) > 0.1) ++other;
  }
  EXPECT_GT(other, 10);
}

TEST(Scene, BlankGroundHasNoTexture) {
  SceneOptions options = bareGround();
  options.blank_share = 1;
  options.crop_share = 0;
  options.road_spacing_m = 0;
  const Scene scene(options, area(), kSeed);
  const Eigen::Vector3f first = scene.radiance(*scene.hit({950, -300, 50}, {0, 0, -1}), 0.01);
  for (double x = 905; x < 995; x += 1.7) {
    const Eigen::Vector3f other = scene.radiance(*scene.hit({x, -290, 50}, {0, 0, -1}), 0.01);
    EXPECT_LT((first - other).norm(), 1e-6F);
  }
}

TEST(Scene, RefusesAnEmptyArea) {
  EXPECT_THROW(Scene({}, Eigen::AlignedBox2d(), kSeed), UsageError);
}

}  // namespace
}  // namespace cf
