// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// MRPT's own tools read every rawlog that we write.
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "cf/rawlog/rawlog_writer.h"
#include "support/recordings.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

using support::CommandResult;

class StockTools : public ::testing::Test {
 protected:
  void SetUp() override {
    if (support::runCommand("command -v rawlog-edit").status != 0)
      GTEST_SKIP() << "rawlog-edit (Debian: mrpt-apps) is not installed";
    RawlogWriter writer(folder_ / "uav.rawlog");
    for (int i = 0; i < kPhotos; ++i) {
      writer.write(support::fullPhoto(folder_ / "uav.rawlog", i));
      writer.write(support::fullFix(i));
    }
    writer.finish();
    std::filesystem::create_directory(folder_ / "uav_Images");
    for (int i = 0; i < kPhotos; ++i)
      cv::imwrite(support::fullPhoto(folder_ / "uav.rawlog", i).file.string(),
                  cv::Mat(9, 16, CV_8UC3, cv::Scalar(10, 120, 60)));
  }
  CommandResult rawlogEdit(const std::string& arguments) {
    const CommandResult r = support::runCommand("cd '" + folder_.path().string() +
                                                "' && rawlog-edit -i uav.rawlog " + arguments);
    EXPECT_EQ(r.status, 0) << r.output;
    return r;
  }
  static constexpr int kPhotos = 5;
  support::TempFolder folder_;
};

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST_F(StockTools, InfoListsSensorsTimesAndImages) {
  const std::string out = rawlogEdit("--info").output;
  EXPECT_TRUE(contains(out, "Found external storage directory: uav_Images")) << out;
  EXPECT_TRUE(contains(out, "CAMERA, CAMERA_GIMBAL, GPS")) << out;
  EXPECT_TRUE(contains(out, "2016/06/23,16:31:59.000000 UTC")) << out;
  EXPECT_TRUE(contains(out, ": 26"))
      << "photo, note, attitude, fix, note, five times, and the end\n"
      << out;
}

TEST_F(StockTools, ListImagesNamesEveryPhoto) {
  rawlogEdit("--list-images --text-file-output images.txt");
  const std::string list = support::fileText(folder_ / "images.txt");
  for (int i = 0; i < kPhotos; ++i)
    EXPECT_TRUE(contains(list, support::fullPhoto(folder_ / "uav.rawlog", i).name)) << list;
}

TEST_F(StockTools, GpsIsExportedAsKml) {
  rawlogEdit("--export-gps-kml");
  const std::string kml = support::fileText(folder_ / "uav.kml");
  EXPECT_TRUE(contains(kml, "-91.993696")) << kml;
  EXPECT_TRUE(contains(kml, "46.842864")) << kml;
}

TEST_F(StockTools, GpsIsExportedAsText) {
  rawlogEdit("--export-gps-txt");
  const std::string text = support::fileText(folder_ / "uav_GPS.txt");
  EXPECT_TRUE(contains(text, "1466699519.0000")) << text;
  EXPECT_TRUE(contains(text, "198.309")) << text;
}

TEST_F(StockTools, DescribePrintsTheCalibration) {
  const std::string out = rawlogEdit("--describe").output;
  EXPECT_TRUE(contains(out, "2311.25")) << out.substr(0, 3000);
  EXPECT_TRUE(contains(out, "sigma_enu_m = 0.0123 0.0145 0.0331")) << out.substr(0, 3000);
}

}  // namespace
}  // namespace cf
