// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/geodesy/crs.h"

#include <gtest/gtest.h>

namespace cf {
namespace {

TEST(Crs, UtmInEveryWayOfWritingIt) {
  for (const char* text :
       {"EPSG:32617", "epsg:32617", "WGS84 UTM 17N", "wgs84 utm 17n", "+proj=utm +zone=17",
        "+proj=utm +zone=17 +ellps=WGS84 +datum=WGS84 +units=m +no_defs",
        "+proj=utm +zone=17 +datum=WGS84 +type=crs"}) {
    const auto crs = crsFromText(text);
    ASSERT_TRUE(crs.ok()) << text;
    ASSERT_TRUE(crs->utm) << text;
    EXPECT_EQ(crs->utm->epsg(), 32617) << text;
    EXPECT_EQ(crs->datum, HeightDatum::kUnknown) << text;
  }
  for (const char* text :
       {"EPSG:32756", "WGS84 UTM 56S", "+proj=utm +zone=56 +south +datum=WGS84 +units=m"}) {
    const auto crs = crsFromText(text);
    ASSERT_TRUE(crs.ok()) << text;
    EXPECT_EQ(crs->utm->text(), "56S") << text;
  }
}

TEST(Crs, Geographic) {
  for (const char* text : {"EPSG:4326", "+proj=longlat +datum=WGS84 +no_defs", "+proj=latlong"}) {
    const auto crs = crsFromText(text);
    ASSERT_TRUE(crs.ok()) << text;
    EXPECT_FALSE(crs->utm) << text;
    EXPECT_EQ(crs->datum, HeightDatum::kUnknown) << text;
  }
  EXPECT_EQ(crsFromText("EPSG:4979")->datum, HeightDatum::kEllipsoid);
}

TEST(Crs, WhatMeansSomethingElseFails) {
  for (const char* text :
       {"", "UTM 17N", "WGS84 UTM 61N", "EPSG:3857", "EPSG:x", "EPSG:32617.5", "EPSG:9e99",
        "+proj=utm", "+proj=utm +zone=0", "+proj=utm +zone=17 +datum=NAD83",
        "+proj=utm +zone=17 +ellps=GRS80", "+proj=utm +zone=17 +units=us-ft",
        "+proj=utm +zone=17 +geoidgrids=egm96.gtx", "+proj=tmerc +lon_0=9", "+proj=utm zone=17",
        "+ +proj=utm +zone=17"}) {
    const auto crs = crsFromText(text);
    ASSERT_FALSE(crs.ok()) << text;
    EXPECT_NE(crs.failure().detail.find("EPSG:4326"), std::string::npos) << text;
  }
}

TEST(Crs, PositionsBecomeGeodetic) {
  const auto zone = crsFromText("WGS84 UTM 17N");
  const auto utm = geodeticToUtm({17, true}, {28.041, -82.698, 0});
  const auto p = geodeticFrom(*zone, {utm->easting_m, utm->northing_m, 3});
  ASSERT_TRUE(p.ok());
  EXPECT_NEAR(p->latitude_deg, 28.041, 1e-10);
  EXPECT_NEAR(p->longitude_deg, -82.698, 1e-10);
  EXPECT_EQ(p->height_m, 3);
  EXPECT_FALSE(geodeticFrom(*zone, {5e7, 0, 0}).ok());

  const auto geographic = crsFromText("EPSG:4326");
  EXPECT_EQ(geodeticFrom(*geographic, {-82.5, 28, 3})->longitude_deg, -82.5);
  EXPECT_FALSE(geodeticFrom(*geographic, {28, -97.5, 3}).ok());  // the wrong order
}

}  // namespace
}  // namespace cf
