// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/geotiff.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <sstream>

#include "cf/base/error.h"
#include "cf/formats/reduced_raster.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

const GeoTiffGrid kGrid = {1200, 700, 381000, 5201000, 0.25, "EPSG:32632"};

nlohmann::json gdalinfo(const fs::path& file) {
  const auto result = support::runCommand("gdalinfo -json '" + file.string() + "'");
  EXPECT_EQ(result.status, 0) << result.output;
  return nlohmann::json::parse(result.output);
}

bool haveGdalinfo() { return support::runCommand("gdalinfo --version").status == 0; }

TEST(GeoTiff, HeightsComeBackAndNothingStaysNothing) {
  const support::TempFolder folder;
  GeoTiffWriter out(folder / "a.tif", GeoTiffWriter::Kind::kHeights, kGrid, {{"KEY", "value"}});
  cv::Mat window(200, 300, CV_32FC1, cv::Scalar(540.125F));
  window.at<float>(3, 5) = std::numeric_limits<float>::quiet_NaN();
  out.write(512, 100, window);
  EXPECT_FALSE(fs::exists(folder / "a.tif")) << "it appears at close()";
  out.close();
  const GeoTiffReader in(folder / "a.tif");
  EXPECT_EQ(in.grid().width, 1200);
  EXPECT_EQ(in.grid().height, 700);
  EXPECT_EQ(in.grid().left_m, 381000);
  EXPECT_EQ(in.grid().top_m, 5201000);
  EXPECT_EQ(in.grid().cell_m, 0.25);
  const cv::Mat back = in.heights({510, 99, 10, 10});
  EXPECT_TRUE(std::isnan(back.at<float>(0, 0)));
  EXPECT_TRUE(std::isnan(back.at<float>(4, 7)));
  EXPECT_EQ(back.at<float>(5, 7), 540.125F);
  const cv::Mat beyond = in.heights({-5, -5, 10, 10});
  EXPECT_TRUE(std::isnan(beyond.at<float>(0, 0)));
}

TEST(GeoTiff, StockToolsFindReferenceSystemTilesAndOverviews) {
  if (!haveGdalinfo()) GTEST_SKIP() << "gdalinfo is not installed";
  const support::TempFolder folder;
  GeoTiffWriter heights(folder / "h.tif", GeoTiffWriter::Kind::kHeights, kGrid, {{"KEY", "value"}});
  heights.write(0, 0, cv::Mat(700, 1200, CV_32FC1, cv::Scalar(7)));
  heights.close();
  const auto h = gdalinfo(folder / "h.tif");
  EXPECT_EQ(h["stac"]["proj:epsg"], 32632);
  EXPECT_EQ(h["geoTransform"], nlohmann::json({381000.0, 0.25, 0.0, 5201000.0, 0.0, -0.25}));
  EXPECT_EQ(h["bands"][0]["noDataValue"], -9999.0);
  EXPECT_EQ(h["bands"][0]["block"], nlohmann::json({512, 512}));
  EXPECT_EQ(h["bands"][0]["overviews"].size(), 3u);
  EXPECT_EQ(h["metadata"]["IMAGE_STRUCTURE"]["COMPRESSION"], "DEFLATE");
  EXPECT_EQ(h["metadata"][""]["KEY"], "value");

  GeoTiffWriter colours(folder / "c.tif", GeoTiffWriter::Kind::kColours, kGrid, {});
  cv::Mat window(512, 512, CV_8UC4, cv::Scalar(30, 90, 200, 255));
  window.col(0).setTo(cv::Scalar::all(0));
  colours.write(0, 0, window);
  colours.close();
  const auto c = gdalinfo(folder / "c.tif");
  EXPECT_EQ(c["bands"].size(), 3u);
  EXPECT_EQ(c["bands"][0]["mask"]["flags"], nlohmann::json({"PER_DATASET"}));
  EXPECT_EQ(c["bands"][0]["overviews"].size(), 3u);
  EXPECT_EQ(fs::exists((folder / "c.tif").string() + ".msk"), false);
  const auto pixel = support::runCommand("gdallocationinfo -valonly '" +
                                         (folder / "c.tif").string() + "' 300 300");
  const int expected[] = {200, 90, 30};
  std::istringstream values(pixel.output);
  for (const int e : expected) {
    int value = -1;
    values >> value;
    EXPECT_NEAR(value, e, 2);  // it is JPEG
  }
}

TEST(GeoTiff, ASmallOneHasNoOverviewsAndNoReferenceSystemIfNoneIsGiven) {
  if (!haveGdalinfo()) GTEST_SKIP() << "gdalinfo is not installed";
  const support::TempFolder folder;
  GeoTiffWriter out(folder / "a.tif", GeoTiffWriter::Kind::kHeights, {100, 80, 0, 8, 0.1, ""}, {});
  out.write(0, 0, cv::Mat(80, 100, CV_32FC1, cv::Scalar(7)));
  out.close();
  const auto info = gdalinfo(folder / "a.tif");
  EXPECT_FALSE(info["bands"][0].contains("overviews"));
  EXPECT_FALSE(info.contains("coordinateSystem"));
}

TEST(ReducedRaster, IsTheWholeAveragedDownToWhatIsAskedFor) {
  const support::TempFolder folder;
  GeoTiffWriter heights(folder / "h.tif", GeoTiffWriter::Kind::kHeights, kGrid, {});
  cv::Mat window(700, 1200, CV_32FC1, cv::Scalar(10));
  window.colRange(600, 1200).setTo(20);
  window(cv::Rect(200, 200, 200, 200)).setTo(std::numeric_limits<float>::quiet_NaN());
  heights.write(0, 0, window);
  heights.close();
  const ReducedRaster h = readReduced(folder / "h.tif", 120);
  ASSERT_EQ(h.values.size(), cv::Size(120, 70));
  ASSERT_EQ(h.values.type(), CV_32FC1);
  EXPECT_EQ(h.grid.cell_m, 2.5);
  EXPECT_EQ(h.grid.left_m, kGrid.left_m);
  EXPECT_EQ(h.values.at<float>(5, 30), 10);
  EXPECT_EQ(h.values.at<float>(65, 90), 20);
  EXPECT_TRUE(std::isnan(h.values.at<float>(30, 30)));
  EXPECT_EQ(readReduced(folder / "h.tif", 5000).values.size(), cv::Size(1200, 700));

  GeoTiffWriter colours(folder / "c.tif", GeoTiffWriter::Kind::kColours, kGrid, {});
  colours.write(0, 0, cv::Mat(512, 512, CV_8UC4, cv::Scalar(30, 90, 200, 255)));
  colours.close();
  const ReducedRaster c = readReduced(folder / "c.tif", 120);
  ASSERT_EQ(c.values.type(), CV_8UC4);
  const auto seen = c.values.at<cv::Vec4b>(20, 20);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(seen[k], (cv::Vec3i{30, 90, 200})[k], 2);  // it is JPEG
  EXPECT_EQ(seen[3], 255);
  EXPECT_EQ(c.values.at<cv::Vec4b>(20, 100)[3], 0);
  EXPECT_THROW((void)readReduced(folder / "none.tif", 120), RunError);
}

TEST(GeoTiff, IsNotLeftHalfWritten) {
  const support::TempFolder folder;
  {
    GeoTiffWriter out(folder / "a.tif", GeoTiffWriter::Kind::kHeights, kGrid, {});
    EXPECT_THROW(out.write(0, 0, cv::Mat(2, 2, CV_8UC4, cv::Scalar(0))), RunError);
  }
  EXPECT_TRUE(fs::is_empty(folder.path()));
  EXPECT_THROW(GeoTiffWriter(folder / "no/a.tif", GeoTiffWriter::Kind::kHeights, kGrid, {}),
               RunError);
  EXPECT_THROW(GeoTiffReader(folder / "none.tif"), RunError);
  EXPECT_THROW(GeoTiffWriter(folder / "a.tif", GeoTiffWriter::Kind::kHeights,
                             {100, 80, 0, 8, 0.1, "EPSG:none"}, {}),
               RunError);
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

}  // namespace
}  // namespace cf
