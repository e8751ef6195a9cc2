// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/import/strips.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace cf {
namespace {

using Track = std::vector<std::optional<Eigen::Vector2d>>;

/// Lines of `photos` photos along x, alternately forth and back, `spacing_m` apart; between them
/// `turning` photos on the way across.
Track lawnMower(int lines, int photos, double step_m, double spacing_m, double noise_m,
                int turning = 0) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, noise_m);
  Track track;
  const auto add = [&](double x, double y) {
    track.push_back(Eigen::Vector2d(x + noise(random), y + noise(random)));
  };
  for (int line = 0; line < lines; ++line) {
    for (int i = 0; i < photos; ++i)
      add((line % 2 == 0 ? i : photos - 1 - i) * step_m, line * spacing_m);
    const double end = line % 2 == 0 ? photos * step_m : -step_m;
    for (int i = 0; i < turning && line + 1 < lines; ++i)
      add(end, (line + (i + 0.5) / turning) * spacing_m);
  }
  return track;
}

int countOf(const std::vector<int>& strips) {
  return strips.empty() ? 0 : 1 + *std::max_element(strips.begin(), strips.end());
}

/// Photos whose strip is not that of their line.
int wrong(const std::vector<int>& strips, int photos) {
  int count = 0;
  for (std::size_t i = 0; i < strips.size(); ++i)
    count += strips[i] != static_cast<int>(i) / photos ? 1 : 0;
  return count;
}

TEST(Strips, ThreeShortLines) {
  for (const double noise : {0.0, 0.3, 1.0}) {
    const auto strips = stripsOf(lawnMower(3, 6, 13.5, 27, noise));
    EXPECT_EQ(wrong(strips, 6), 0) << "noise " << noise;
  }
}

TEST(Strips, LongLines) {
  for (const double noise : {0.0, 0.5, 1.5}) {
    const auto strips = stripsOf(lawnMower(8, 40, 8, 15, noise));
    EXPECT_EQ(countOf(strips), 8) << "noise " << noise;
    EXPECT_LE(wrong(strips, 40), 7) << "a photo at a turn may belong to either line";
  }
}

TEST(Strips, TurningPhotosJoinTheirNeighbours) {
  EXPECT_EQ(countOf(stripsOf(lawnMower(5, 20, 8, 30, 0.3, 4))), 5);
}

TEST(Strips, OneStraightLineIsOneStrip) {
  for (const double noise : {0.0, 0.5, 4.0})
    EXPECT_EQ(countOf(stripsOf(lawnMower(1, 60, 5, 0, noise))), 1) << "noise " << noise;
}

TEST(Strips, ForthAndBackOnTheSameLineAreTwo) {
  EXPECT_LE(wrong(stripsOf(lawnMower(2, 15, 10, 0, 0.3)), 15), 1);
  EXPECT_EQ(countOf(stripsOf(lawnMower(2, 15, 10, 0, 0.3))), 2);
}

TEST(Strips, PhotosWithoutAPositionJoinTheOneBefore) {
  Track track = lawnMower(2, 8, 10, 20, 0);
  track[3].reset();
  track[8].reset();
  const auto strips = stripsOf(track);
  ASSERT_EQ(strips.size(), 16u);
  EXPECT_EQ(strips[3], 0);
  EXPECT_EQ(strips[8], 0);
  EXPECT_EQ(strips[9], 1);
}

TEST(Strips, WithoutPositionsThereAreNone) {
  EXPECT_TRUE(stripsOf(Track(5)).empty());
  EXPECT_TRUE(stripsOf({}).empty());
}

TEST(Strips, HoveringIsOneStrip) { EXPECT_EQ(countOf(stripsOf(lawnMower(1, 20, 0, 0, 0))), 1); }

}  // namespace
}  // namespace cf
