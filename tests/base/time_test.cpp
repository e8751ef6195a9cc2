// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/base/time.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "cf/base/error.h"

namespace cf {
namespace {

TEST(Time, knownTexts) {
  EXPECT_EQ(timeText(0), "0.000000000");
  EXPECT_EQ(timeText(1466699519'000000000), "1466699519.000000000");
  EXPECT_EQ(timeText(1), "0.000000001");
  EXPECT_EQ(timeText(-1500000000), "-1.500000000");
  EXPECT_EQ(timeText(std::numeric_limits<TimeNs>::min()), "-9223372036.854775808");
  EXPECT_EQ(timeFromText("1466699519.25"), 1466699519'250000000);
  EXPECT_EQ(timeFromText("12"), 12 * kNsPerSecond);
  EXPECT_EQ(timeFromText("-0.000000001"), -1);
}

TEST(Time, textGoesRoundExactly) {
  std::mt19937_64 random(1);
  std::uniform_int_distribution<TimeNs> any(-9'000'000'000'000'000'000, 9'000'000'000'000'000'000);
  for (int i = 0; i < 10000; ++i) {
    const TimeNs t = any(random);
    ASSERT_EQ(timeFromText(timeText(t)), t);
  }
}

TEST(Time, digitsBeyondNanosecondsAreDropped) {
  EXPECT_EQ(timeFromText("1.0000000019"), 1'000000001);
}

TEST(Time, anythingElseIsAnError) {
  for (const char* text : {"", "-", ".5", "abc", "1.5x", " 1", "1 ", "1e9", "+1", "1,5", "--1",
                           "99999999999", "9223372037", "1.2.3", "nan"})
    EXPECT_THROW(timeFromText(text), RunError) << "'" << text << "'";
}

TEST(Time, isoForPeople) {
  EXPECT_EQ(isoText(0), "1970-01-01T00:00:00Z");
  EXPECT_EQ(isoText(1466699519'900000000), "2016-06-23T16:31:59Z");
}

}  // namespace
}  // namespace cf
