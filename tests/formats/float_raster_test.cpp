// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/float_raster.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>

#include "cf/base/error.h"
#include "support/message_of.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

TEST(FloatRaster, ValuesAndAllAroundThemReturn) {
  const support::TempFolder folder;
  FloatRaster raster;
  raster.values.create(301, 517, CV_32FC1);  // no multiple of a tile
  for (int y = 0; y < raster.values.rows; ++y)
    for (int x = 0; x < raster.values.cols; ++x)
      raster.values.at<float>(y, x) = 100.125F + 0.01F * static_cast<float>(x * y % 977);
  raster.values.at<float>(7, 9) = std::numeric_limits<float>::quiet_NaN();
  raster.values.at<float>(0, 0) = 0;
  raster.metadata = {{"STEP", "3"}, {"ORIGIN_E", "-12.5"}};
  raster.geotransform = {500000.5, 0.25, 0.001, 4100000, 0.001, -0.25};
  raster.crs_wkt_or_epsg = "EPSG:32615";
  writeFloatRaster(folder / "a.tif", raster);

  const FloatRaster read = readFloatRaster(folder / "a.tif");
  ASSERT_EQ(read.values.size(), raster.values.size());
  ASSERT_EQ(read.values.type(), CV_32FC1);
  for (int y = 0; y < raster.values.rows; ++y)
    for (int x = 0; x < raster.values.cols; ++x) {
      const float was = raster.values.at<float>(y, x), is = read.values.at<float>(y, x);
      ASSERT_TRUE(was == is || (std::isnan(was) && std::isnan(is))) << x << " " << y;
    }
  EXPECT_EQ(read.metadata.at("STEP"), "3");
  EXPECT_EQ(read.metadata.at("ORIGIN_E"), "-12.5");
  EXPECT_EQ(read.geotransform, raster.geotransform);
  EXPECT_EQ(read.crs_wkt_or_epsg, "EPSG:32615");
  EXPECT_FALSE(std::filesystem::exists(folder / "a.tif.tmp"));
}

TEST(FloatRaster, PartOfALargerMatrixAndNothingElse) {
  const support::TempFolder folder;
  cv::Mat whole(20, 30, CV_32FC1, cv::Scalar(1));
  whole(cv::Rect(5, 4, 8, 7)).setTo(2);
  FloatRaster raster;
  raster.values = whole(cv::Rect(5, 4, 8, 7));
  writeFloatRaster(folder / "a.tif", raster);
  const FloatRaster read = readFloatRaster(folder / "a.tif");
  EXPECT_EQ(cv::countNonZero(read.values == 2), 8 * 7);
  EXPECT_FALSE(read.geotransform);
  EXPECT_EQ(read.crs_wkt_or_epsg, "");
}

std::string runError(void (*body)(const std::filesystem::path&),
                     const std::filesystem::path& path) {
  return support::messageOf<RunError>([&] { body(path); });
}

TEST(FloatRaster, FaultsAreOneLineThatNamesTheFile) {
  const support::TempFolder folder;
  support::writeText(folder / "text.tif", "nonsense");
  FloatRaster raster;
  raster.values = cv::Mat(600, 600, CV_32FC1, cv::Scalar(1.5));
  writeFloatRaster(folder / "cut.tif", raster);
  std::filesystem::resize_file(folder / "cut.tif",
                               std::filesystem::file_size(folder / "cut.tif") / 2);
  const auto read = [](const std::filesystem::path& p) { static_cast<void>(readFloatRaster(p)); };
  for (const char* name : {"none.tif", "text.tif", "cut.tif"}) {
    const std::string line = runError(read, folder / name);
    EXPECT_EQ(line.rfind((folder / name).string() + ": ", 0), 0u) << line;
    EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 0) << line;
  }
  const auto write = [](const std::filesystem::path& p) {
    FloatRaster one;
    one.values = cv::Mat(1, 1, CV_32FC1, cv::Scalar(1));
    writeFloatRaster(p, one);
  };
  EXPECT_NE(runError(write, folder / "no/such/folder.tif").find("folder.tif"), std::string::npos);
  const auto empty = [](const std::filesystem::path& p) { writeFloatRaster(p, {}); };
  EXPECT_NE(runError(empty, folder / "b.tif").find("b.tif"), std::string::npos);
}

}  // namespace
}  // namespace cf
