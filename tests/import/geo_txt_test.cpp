// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/import/geo_txt.h"

#include <gtest/gtest.h>

#include "cf/base/error.h"
#include "cf/geodesy/utm.h"
#include "support/message_of.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

class GeoTxt : public ::testing::Test {
 protected:
  GeoFile geo(const std::string& text) {
    support::writeText(path_, text);
    return readGeoTxt(path_);
  }
  support::TempFolder folder_;
  const std::filesystem::path path_ = folder_ / "geo.txt";
};

TEST_F(GeoTxt, ReadsLongitudeFirst) {
  const GeoFile g = geo("EPSG:4326\n# comment\n\na.jpg -91.99 46.84 198.5\r\n");
  ASSERT_EQ(g.entries.size(), 1u);
  EXPECT_EQ(g.entries[0].name, "a.jpg");
  EXPECT_EQ(g.entries[0].position.latitude_deg, 46.84);
  EXPECT_EQ(g.entries[0].position.longitude_deg, -91.99);
  EXPECT_EQ(g.entries[0].position.height_m, 198.5);
  EXPECT_FALSE(g.entries[0].attitude);
  EXPECT_FALSE(g.entries[0].sigma_m);
  EXPECT_EQ(g.datum, HeightDatum::kUnknown);
  EXPECT_EQ(geo("EPSG:4979\na 1 2 3").datum, HeightDatum::kEllipsoid);
}

TEST_F(GeoTxt, ReadsAttitudeAndSigmasInEitherCombination) {
  const GeoFile g = geo("EPSG:4326\na 1 2 3 0.02 0.05\nb 1 2 3 10 -90 0\nc 1 2 3 10 -80 1 2 4\n");
  EXPECT_EQ(*g.entries[0].sigma_m, Eigen::Vector2d(0.02, 0.05));
  EXPECT_FALSE(g.entries[0].attitude);
  EXPECT_EQ(g.entries[1].attitude->pitch_deg, -90);
  EXPECT_FALSE(g.entries[1].sigma_m);
  EXPECT_EQ(g.entries[2].attitude->roll_deg, 1);
  EXPECT_EQ(*g.entries[2].sigma_m, Eigen::Vector2d(2, 4));
}

TEST_F(GeoTxt, ReadsUtmByCodeAndByName) {
  const auto utm = geodeticToUtm({17, true}, {28.041, -82.698, 0});
  const std::string line =
      "a " + std::to_string(utm->easting_m) + " " + std::to_string(utm->northing_m) + " 3\n";
  for (const char* crs : {"EPSG:32617", "WGS84 UTM 17N", "wgs84 utm 17n"}) {
    const GeoFile g = geo(std::string(crs) + "\n" + line);
    EXPECT_NEAR(g.entries[0].position.latitude_deg, 28.041, 1e-10);
    EXPECT_NEAR(g.entries[0].position.longitude_deg, -82.698, 1e-10);
  }
}

TEST_F(GeoTxt, ErrorsNameFileAndLine) {
  EXPECT_NE(support::messageOf<UsageError>([&] { geo("EPSG:3857\na 1 2 3\n"); }).find("geo.txt:1"),
            std::string::npos);
  EXPECT_NE(support::messageOf<UsageError>([&] { geo("EPSG:4326\na 1 2\n"); }).find("geo.txt:2"),
            std::string::npos);
  EXPECT_NE(support::messageOf<UsageError>([&] { geo("EPSG:4326\na 1 2x 3\n"); }).find("'2x'"),
            std::string::npos);
  EXPECT_NE(support::messageOf<UsageError>([&] { geo("EPSG:4326\na 1 2 3 0 1\n"); }).find("sigmas"),
            std::string::npos);
  EXPECT_NE(support::messageOf<UsageError>([&] {
              geo("EPSG:4326\na 46 -91.99 3\n");
            }).find("in this order"),
            std::string::npos);
  EXPECT_NE(support::messageOf<UsageError>([&] { geo("EPSG:4326\n"); }).find("names no photo"),
            std::string::npos);
  EXPECT_NE(
      support::messageOf<UsageError>([&] { readGeoTxt(folder_ / "none.txt"); }).find("none.txt"),
      std::string::npos);
}

}  // namespace
}  // namespace cf
