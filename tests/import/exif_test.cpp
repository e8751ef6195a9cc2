// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/import/exif.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "support/exif_jpeg.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

using support::ExifJpeg;
constexpr TimeNs k20160623_163159 = 1466699519 * kNsPerSecond;

PhotoTags readBack(const ExifJpeg& jpeg, int width = 64, int height = 48) {
  support::TempFolder folder;
  jpeg.write(folder / "a.jpg", width, height);
  return readPhotoTags(folder / "a.jpg");
}

TEST(Exif, ReadsSizeTimePositionAndFocalTags) {
  const PhotoTags tags = readBack(ExifJpeg()
                                      .dateTime("2016:06:23 16:31:59")
                                      .rationals(ExifJpeg::kExif, 0x920A, {3.61}, 100)
                                      .word(ExifJpeg::kExif, 0xA405, 20)
                                      .position(46.8426, -91.9945, 198.309));
  EXPECT_TRUE(tags.readable);
  EXPECT_EQ(tags.width, 64);
  EXPECT_EQ(tags.height, 48);
  EXPECT_EQ(tags.time.camera, k20160623_163159);
  EXPECT_FALSE(tags.time.gps);
  EXPECT_FALSE(tags.time.sub_seconds);
  EXPECT_EQ(tags.focal.focal_mm, 3.61);
  EXPECT_EQ(tags.focal.focal_35mm, 20);
  ASSERT_TRUE(tags.position);
  EXPECT_NEAR(tags.position->latitude_deg, 46.8426, 1e-7);
  EXPECT_NEAR(tags.position->longitude_deg, -91.9945, 1e-7);
  EXPECT_EQ(tags.position->height_m, 198.309);
  EXPECT_EQ(tags.position->datum, HeightDatum::kUnknown);
  EXPECT_FALSE(tags.position->sigma_enu_m);
  EXPECT_FALSE(tags.attitude);
}

TEST(Exif, BelowSeaLevelIsNegative) {
  EXPECT_EQ(readBack(ExifJpeg().position(28, 82, -5.677)).position->height_m, -5.677);
}

TEST(Exif, SubSecondsAndOffsetMakeUtc) {
  const PhotoTags tags = readBack(ExifJpeg()
                                      .dateTime("2016:06:23 18:31:59")
                                      .text(ExifJpeg::kExif, 0x9011, "+02:00")
                                      .text(ExifJpeg::kExif, 0x9291, "125"));
  EXPECT_EQ(tags.time.camera, k20160623_163159 + kNsPerSecond / 8);
  EXPECT_TRUE(tags.time.sub_seconds);
}

TEST(Exif, GpsTimeIsUtc) {
  const PhotoTags tags = readBack(ExifJpeg()
                                      .text(ExifJpeg::kGps, 29, "2016:06:23")
                                      .rationals(ExifJpeg::kGps, 7, {16, 31, 59.2}, 10));
  EXPECT_EQ(tags.time.gps, k20160623_163159 + kNsPerSecond / 5);
}

TEST(Exif, DjiXmpGivesGimbalHeightAndRtk) {
  const PhotoTags tags = readBack(
      ExifJpeg()
          .position(46.8, -91.9, 100)
          .xmp("drone-dji:GimbalYawDegree=\"+45.00\" drone-dji:GimbalPitchDegree=\"-89.90\" "
               "drone-dji:GimbalRollDegree=\"+0.10\" drone-dji:RelativeAltitude=\"+39.80\" "
               "drone-dji:AbsoluteAltitude=\"+231.512\" drone-dji:GpsLatitude=\"46.800001234\" "
               "drone-dji:GpsLongitude=\"-91.900001234\" drone-dji:RtkStdLon=\"0.012\" "
               "drone-dji:RtkStdLat=\"0.013\" drone-dji:RtkStdHgt=\"0.027\""));
  ASSERT_TRUE(tags.attitude);
  EXPECT_EQ(tags.attitude->yaw_deg, 45);
  EXPECT_EQ(tags.attitude->pitch_deg, -89.9);
  EXPECT_EQ(tags.attitude->roll_deg, 0.1);
  EXPECT_EQ(tags.height_above_ground_m, 39.8);
  ASSERT_TRUE(tags.position && tags.position->sigma_enu_m);
  EXPECT_EQ(*tags.position->sigma_enu_m, Eigen::Vector3d(0.012, 0.013, 0.027));
  EXPECT_EQ(tags.position->latitude_deg, 46.800001234);
  EXPECT_EQ(tags.position->longitude_deg, -91.900001234);
  EXPECT_EQ(tags.position->height_m, 231.512);
  EXPECT_EQ(tags.position->datum, HeightDatum::kEllipsoid);
}

TEST(Exif, XmpElementsAndLongerNamesAreToldApart) {
  const std::string xmp =
      "<a:GimbalYawDegreeRaw>7</a:GimbalYawDegreeRaw><a:GimbalYawDegree> +1.5 "
      "</a:GimbalYawDegree> b:Roll = '2'";
  EXPECT_EQ(xmpValue(xmp, "GimbalYawDegree"), "+1.5");
  EXPECT_EQ(xmpValue(xmp, "Roll"), "2");
  EXPECT_EQ(xmpValue(xmp, "Pitch"), "");
}

TEST(Exif, NoReceptionIsNoPosition) {
  EXPECT_FALSE(readBack(ExifJpeg().position(0, 0, 0)).position);
  EXPECT_FALSE(readBack(ExifJpeg().position(46, 9, 0).text(ExifJpeg::kGps, 9, "V")).position);
  EXPECT_FALSE(readBack(ExifJpeg()).position);
}

TEST(Exif, AClockThatWasNeverSetIsNoTime) {
  EXPECT_FALSE(readBack(ExifJpeg().dateTime("0000:00:00 00:00:00")).time.camera);
  EXPECT_FALSE(readBack(ExifJpeg().dateTime("yesterday")).time.camera);
}

TEST(Exif, OrientationIsRead) {
  EXPECT_EQ(readBack(ExifJpeg().word(ExifJpeg::kMain, 0x0112, 6)).orientation, 6);
}

TEST(Exif, WhatIsNoImageIsUnreadable) {
  support::TempFolder folder;
  support::writeText(folder / "empty.jpg", "");
  support::writeText(folder / "text.jpg", "no image");
  for (const char* name : {"empty.jpg", "text.jpg", "missing.jpg"})
    EXPECT_FALSE(readPhotoTags(folder / name).readable) << name;
}

TEST(Exif, ATruncatedJpegKeepsItsTags) {
  support::TempFolder folder;
  ExifJpeg().dateTime("2016:06:23 16:31:59").write(folder / "a.jpg", 640, 480);
  const std::string bytes = support::fileText(folder / "a.jpg");
  support::writeText(folder / "a.jpg", bytes.substr(0, bytes.size() - 300));
  const PhotoTags tags = readPhotoTags(folder / "a.jpg");
  EXPECT_TRUE(tags.readable);
  EXPECT_EQ(tags.time.camera, k20160623_163159);
}

TEST(ExifOfRealFlights, Dji) {
  const std::filesystem::path photo =
      std::filesystem::path(CF_REAL_DATA) / "brighton_beach/images/DJI_0018.JPG";
  if (!std::filesystem::exists(photo)) GTEST_SKIP() << photo << " is not here";
  const PhotoTags tags = readPhotoTags(photo);
  EXPECT_EQ(tags.width, 4000);
  EXPECT_EQ(tags.height, 2250);
  EXPECT_EQ(tags.time.camera, k20160623_163159);
  ASSERT_TRUE(tags.attitude);
  EXPECT_EQ(tags.attitude->yaw_deg, 45);
  EXPECT_EQ(tags.height_above_ground_m, 39.8);
  ASSERT_TRUE(tags.position);
  EXPECT_NEAR(tags.position->latitude_deg, 46 + 50 / 60.0 + 33.3855 / 3600, 1e-12);
  EXPECT_NEAR(tags.position->longitude_deg, -(91 + 59 / 60.0 + 40.4156 / 3600), 1e-12);
}

TEST(ExifOfRealFlights, Canon) {
  const std::filesystem::path photo =
      std::filesystem::path(CF_REAL_DATA) / "caliterra/images/IMG_9354.jpg";
  if (!std::filesystem::exists(photo)) GTEST_SKIP() << photo << " is not here";
  const PhotoTags tags = readPhotoTags(photo);
  EXPECT_EQ(*tags.time.gps - *tags.time.camera, 5 * 3600 * kNsPerSecond) << "Texas in October";
  EXPECT_NEAR(tags.focal.focal_plane_px_per_mm, 16393.4 / 25.4, 1e-9);
  EXPECT_EQ(tags.focal.original_width, 4000);
}

}  // namespace
}  // namespace cf
