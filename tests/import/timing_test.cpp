// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/import/timing.h"

#include <gtest/gtest.h>

namespace cf {
namespace {

constexpr TimeNs kS = kNsPerSecond;
constexpr TimeNs kStart = 1466699519 * kS;

PhotoTime camera(TimeNs t) { return {std::nullopt, kStart + t, t % kS != 0}; }

std::vector<TimeNs> timesOf(const std::vector<PhotoTime>& tags) {
  std::vector<TimeNs> times = flightTimes(tags).times;
  for (TimeNs& t : times) t -= kStart;
  return times;
}

TEST(Timing, DifferentTimesAreKept) {
  EXPECT_EQ(timesOf({camera(0), camera(7 * kS), camera(3 * kS + kS / 4)}),
            (std::vector<TimeNs>{0, 7 * kS, 3 * kS + kS / 4}));
}

TEST(Timing, EqualSecondsAreSpreadInOrderOfTheNames) {
  EXPECT_EQ(timesOf({camera(0), camera(0), camera(kS), camera(kS), camera(kS), camera(kS)}),
            (std::vector<TimeNs>{0, kS / 2, kS, kS * 5 / 4, kS * 3 / 2, kS * 7 / 4}));
  EXPECT_EQ(timesOf({camera(0), camera(0), camera(60 * kS)}),
            (std::vector<TimeNs>{0, kS / 2, 60 * kS}))
      << "within their second, however long the gap";
}

TEST(Timing, MissingTimesComeFromNeighboursByName) {
  EXPECT_EQ(timesOf({camera(0), {}, camera(4 * kS)}), (std::vector<TimeNs>{0, 2 * kS, 4 * kS}));
  EXPECT_EQ(timesOf({{}, camera(10 * kS), camera(12 * kS), {}}),
            (std::vector<TimeNs>{8 * kS, 10 * kS, 12 * kS, 14 * kS}));
  EXPECT_EQ(flightTimes({camera(0), {}, camera(4 * kS)}).warnings.size(), 1u);
}

TEST(Timing, WithoutAnyTimeItIsOneASecondAndSaidSo) {
  const FlightTimes f = flightTimes({{}, {}, {}});
  EXPECT_EQ(f.times, (std::vector<TimeNs>{0, kS, 2 * kS}));
  EXPECT_EQ(f.warnings.size(), 1u);
}

TEST(Timing, GpsTimeWinsWhereEveryPhotoHasAFreshOne) {
  const FlightTimes f =
      flightTimes({{kStart + 5 * kS, kStart, false}, {kStart + 7 * kS, kStart + 2 * kS, false}});
  EXPECT_EQ(f.source, "GPS");
  EXPECT_EQ(f.times, (std::vector<TimeNs>{kStart + 5 * kS, kStart + 7 * kS}));
}

TEST(Timing, StaleOrMissingGpsTimesOnlySetTheCamerasClock) {
  const TimeNs zone = 5 * 3600 * kS;
  const FlightTimes stale = flightTimes({{kStart + zone, kStart, false},
                                         {kStart + zone, kStart + 2 * kS, false},
                                         {kStart + zone, kStart + 4 * kS, false}});
  EXPECT_EQ(stale.times[2] - stale.times[0], 4 * kS);
  const FlightTimes missing = flightTimes({{kStart + zone, kStart, false},
                                           {std::nullopt, kStart + 2 * kS, false},
                                           {kStart + zone + 4 * kS, kStart + 4 * kS, false}});
  EXPECT_EQ(missing.times,
            (std::vector<TimeNs>{kStart + zone, kStart + zone + 2 * kS, kStart + zone + 4 * kS}));
}

}  // namespace
}  // namespace cf
