// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/geodesy/utm.h"

#include <gtest/gtest.h>

namespace cf {
namespace {

TEST(Utm, CentralMeridianOnTheEquatorIs500km) {
  const auto utm = geodeticToUtm({31, true}, {0, 3, 0});
  ASSERT_TRUE(utm.ok());
  EXPECT_NEAR(utm->easting_m, 500000, 1e-6);
  EXPECT_NEAR(utm->northing_m, 0, 1e-6);
}

TEST(Utm, ScaleOnTheCentralMeridianIs0_9996) {
  // The meridian arc of WGS84 from the equator to 45 degrees is 4984944.378 m.
  const auto utm = geodeticToUtm({31, true}, {45, 3, 0});
  ASSERT_TRUE(utm.ok());
  EXPECT_NEAR(utm->northing_m, 0.9996 * 4984944.378, 1e-3);
}

TEST(Utm, RoundTripInBothHemispheresAndInANeighbouringZone) {
  for (const auto& [zone, lat, lon] : {std::tuple{UtmZone{17, true}, 28.041, -82.698},
                                       std::tuple{UtmZone{56, false}, -33.9, 151.2},
                                       std::tuple{UtmZone{16, true}, 28.041, -82.698},
                                       std::tuple{UtmZone{36, false}, 0.001, 33.0}}) {
    const auto utm = geodeticToUtm(zone, {lat, lon, 7});
    ASSERT_TRUE(utm.ok()) << utm.failure().detail;
    const auto back = utmToGeodetic(zone, utm->easting_m, utm->northing_m, 7);
    ASSERT_TRUE(back.ok()) << back.failure().detail;
    EXPECT_NEAR(back->latitude_deg, lat, 1e-10);
    EXPECT_NEAR(back->longitude_deg, lon, 1e-10);
    EXPECT_EQ(back->height_m, 7);
  }
}

TEST(Utm, ReadsZonesAndCodes) {
  EXPECT_EQ(utmZoneFromText("17N")->epsg(), 32617);
  EXPECT_EQ(utmZoneFromText("5s")->text(), "5S");
  EXPECT_EQ(utmZoneFromEpsg(32756)->text(), "56S");
  for (const char* bad : {"", "N", "61N", "0N", "17", "17T", "17NN", "170N"})
    EXPECT_FALSE(utmZoneFromText(bad).ok()) << bad;
  for (int bad : {4326, 32600, 32661, 32761}) EXPECT_FALSE(utmZoneFromEpsg(bad).ok()) << bad;
}

TEST(Utm, KnowsTheExceptionOfNorway) { EXPECT_EQ(utmZoneOf(60.39, 5.32).text(), "32N"); }

TEST(Utm, FailsOutsideTheGrid) {
  EXPECT_FALSE(utmToGeodetic({17, true}, 5e7, 0, 0).ok());
  EXPECT_FALSE(geodeticToUtm({17, true}, {28, 100, 0}).ok());
}

}  // namespace
}  // namespace cf
