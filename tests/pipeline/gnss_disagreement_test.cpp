// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "gnss_disagreement.h"

#include <gtest/gtest.h>

namespace cf {
namespace {

UavRecord uavWith(const std::string& name, const Eigen::Vector3d& bias_m) {
  UavRecord uav;
  uav.name = name;
  uav.gnss.bias_m = bias_m;
  uav.gnss.fixes = 9;
  uav.gnss.trusted = true;
  return uav;
}

bool says(const std::vector<std::string>& sentences, const std::string& text) {
  for (const std::string& sentence : sentences)
    if (sentence.find(text) != std::string::npos) return true;
  return false;
}

TEST(GnssDisagreement, OrdinaryBiasesAreNotWorthAWord) {
  EXPECT_TRUE(gnssDisagreements({}).empty());
  EXPECT_TRUE(gnssDisagreements({uavWith("a", {50, 0, 90})}).empty());
  EXPECT_TRUE(gnssDisagreements({uavWith("a", {3, 3, 8}), uavWith("b", {-3, -3, -8})}).empty());
}

// The joint adjustment shares a disagreement among the UAVs: only the one apart is named.
TEST(GnssDisagreement, TheOneApartIsNamed) {
  const auto s = gnssDisagreements(
      {uavWith("west", {0, 0, -16}), uavWith("east", {0, 0, -9}), uavWith("across", {0, 0, 25})});
  ASSERT_EQ(s.size(), 1u);
  EXPECT_TRUE(says(s, "across: its GPS altitude disagrees by 34 m with the other UAVs'")) << s[0];

  const auto sideways = gnssDisagreements({uavWith("a", {0, 0, 0}), uavWith("b", {9, 12, 0}),
                                           uavWith("c", {1, 0, 0}), uavWith("d", {0, 1, 0})});
  ASSERT_EQ(sideways.size(), 1u);
  EXPECT_TRUE(says(sideways, "b: its GPS position disagrees by 14 m")) << sideways[0];
}

TEST(GnssDisagreement, OfTwoNeitherIsRight) {
  const auto s = gnssDisagreements({uavWith("low", {0, 0, -14}), uavWith("high", {0, 0, 22})});
  ASSERT_EQ(s.size(), 1u);
  EXPECT_TRUE(says(s, "low and high: their GPS altitude disagrees by 36 m")) << s[0];
}

TEST(GnssDisagreement, WhatIsNotTrustedIsLeftOut) {
  UavRecord junk = uavWith("junk", {0, 0, 400}), none = uavWith("none", {0, 0, 400});
  junk.gnss.trusted = false;
  none.gnss.fixes = 0;
  EXPECT_TRUE(gnssDisagreements({uavWith("a", {0, 0, 1}), junk, none}).empty());
}

}  // namespace
}  // namespace cf
