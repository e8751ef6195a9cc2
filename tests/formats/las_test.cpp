// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/las.h"

#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "cf/base/error.h"
#include "cf/formats/crs_wkt.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

const Eigen::Vector3d kOffset(381291.4, 5200788.6, 540.2);

void writeThree(const fs::path& path, const std::string& wkt) {
  LasWriter las(path, kOffset, wkt);
  las.add({{381291.001, 5200788.002, 540.003}, {255, 128, 0}, 7});
  las.add({{381191.5, 5200900.25, 531.125}, {1, 2, 3}, 255});
  las.add({{381400.0004, 5200700.0006, 560}, {0, 0, 0}, 1});
  EXPECT_EQ(las.count(), 3u);
  EXPECT_FALSE(fs::exists(path)) << "it appears at close()";
  las.close();
}

template <class T>
T at(const std::string& bytes, std::size_t position) {
  T value{};
  EXPECT_LE(position + sizeof(T), bytes.size());
  std::memcpy(&value, bytes.data() + position, sizeof(T));
  return value;
}

// Positions of the fields as the tables of the specification add up to.
TEST(Las, TheSpecificationsLayoutByteForByte) {
  const support::TempFolder folder;
  writeThree(folder / "a.las", "LOCAL");
  const std::string b = support::fileText(folder / "a.las");
  const std::size_t points = 375 + 54 + 6;
  ASSERT_EQ(b.size(), points + 3 * 36);
  EXPECT_EQ(b.substr(0, 4), "LASF");
  EXPECT_EQ(at<std::uint16_t>(b, 6), 16);  // WKT
  EXPECT_EQ(at<std::uint8_t>(b, 24), 1);
  EXPECT_EQ(at<std::uint8_t>(b, 25), 4);
  EXPECT_EQ(at<std::uint16_t>(b, 94), 375);
  EXPECT_EQ(at<std::uint32_t>(b, 96), points);
  EXPECT_EQ(at<std::uint32_t>(b, 100), 1u);
  EXPECT_EQ(at<std::uint8_t>(b, 104), 7);
  EXPECT_EQ(at<std::uint16_t>(b, 105), 36);
  EXPECT_EQ(at<std::uint32_t>(b, 107), 0u);
  EXPECT_EQ(at<double>(b, 131), 0.001);
  EXPECT_EQ(at<double>(b, 155), 381291);
  EXPECT_EQ(at<double>(b, 163), 5200789);
  EXPECT_EQ(at<double>(b, 171), 540);
  EXPECT_DOUBLE_EQ(at<double>(b, 179), 381400);    // max x
  EXPECT_DOUBLE_EQ(at<double>(b, 187), 381191.5);  // min x
  EXPECT_DOUBLE_EQ(at<double>(b, 195), 5200900.25);
  EXPECT_DOUBLE_EQ(at<double>(b, 203), 5200700.001);
  EXPECT_DOUBLE_EQ(at<double>(b, 211), 560);
  EXPECT_DOUBLE_EQ(at<double>(b, 219), 531.125);
  EXPECT_EQ(at<std::uint64_t>(b, 247), 3u);
  EXPECT_EQ(at<std::uint64_t>(b, 255), 3u);
  EXPECT_EQ(at<std::uint64_t>(b, 263), 0u);
  EXPECT_EQ(b.substr(375 + 2, 15), "LASF_Projection");
  EXPECT_EQ(at<std::uint16_t>(b, 375 + 18), 2112);
  EXPECT_EQ(at<std::uint16_t>(b, 375 + 20), 6);
  EXPECT_EQ(b.substr(375 + 54, 6), std::string("LOCAL\0", 6));
  EXPECT_EQ(at<std::int32_t>(b, points), 1);
  EXPECT_EQ(at<std::int32_t>(b, points + 4), -998);
  EXPECT_EQ(at<std::int32_t>(b, points + 8), 3);
  EXPECT_EQ(at<std::uint8_t>(b, points + 14), 0x11);  // return 1 of 1
  EXPECT_EQ(at<std::uint8_t>(b, points + 16), 0);     // never classified
  EXPECT_EQ(at<std::uint8_t>(b, points + 17), 7);
  EXPECT_EQ(at<double>(b, points + 22), 0);
  EXPECT_EQ(at<std::uint16_t>(b, points + 30), 65535);
  EXPECT_EQ(at<std::uint16_t>(b, points + 32), 128 * 257);
  EXPECT_EQ(at<std::uint16_t>(b, points + 34), 0);
}

// In Python, from the specification alone: tests/formats/read_las.py.
TEST(Las, AnIndependentReaderFindsTheSame) {
  if (support::runCommand("python3 --version").status != 0)
    GTEST_SKIP() << "python3 is not installed";
  const support::TempFolder folder;
  const std::string wkt = crsWkt(32632, HeightDatum::kMsl);
  writeThree(folder / "a.las", wkt);
  const auto read = support::runCommand("python3 '" CF_SOURCE_DIR "/tests/formats/read_las.py' '" +
                                        (folder / "a.las").string() + "'");
  ASSERT_EQ(read.status, 0) << read.output;
  const auto json = nlohmann::json::parse(read.output);
  EXPECT_EQ(json["count"], 3);
  EXPECT_EQ(json["wkt"], wkt);
  EXPECT_EQ(json["classes"], nlohmann::json::array({0}));
  EXPECT_EQ(json["software"], "ClusterFusion");
  const double expected[3][3] = {{381291.001, 5200788.002, 540.003},
                                 {381191.5, 5200900.25, 531.125},
                                 {381400, 5200700.001, 560}};
  for (int i = 0; i < 3; ++i)
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(json["points"][i]["xyz"][axis].get<double>(), expected[i][axis], 1e-6);
  EXPECT_EQ(json["points"][0]["rgb"], nlohmann::json({65535, 128 * 257, 0}));
  EXPECT_EQ(json["points"][1]["user_data"], 255);
  // And it does find what is wrong: a count that the file does not hold.
  std::string broken = support::fileText(folder / "a.las");
  broken[247] = 4;
  support::writeText(folder / "b.las", broken);
  EXPECT_NE(support::runCommand("python3 '" CF_SOURCE_DIR "/tests/formats/read_las.py' '" +
                                (folder / "b.las").string() + "'")
                .status,
            0);
}

TEST(Las, WithoutPointsOrReferenceSystemItIsStillWhole) {
  const support::TempFolder folder;
  LasWriter las(folder / "a.las", {0, 0, 0}, "");
  las.close();
  const std::string b = support::fileText(folder / "a.las");
  EXPECT_EQ(b.size(), 375u);
  EXPECT_EQ(at<std::uint32_t>(b, 100), 0u);
  EXPECT_EQ(at<double>(b, 179), 0);
}

TEST(Las, IsNotLeftHalfWritten) {
  const support::TempFolder folder;
  {
    LasWriter las(folder / "a.las", {0, 0, 0}, "");
    las.add({});
    EXPECT_THROW(las.add({{3e6, 0, 0}, {0, 0, 0}, 0}), RunError);
    EXPECT_THROW(las.add({{0, std::nan(""), 0}, {0, 0, 0}, 0}), RunError);
  }
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(CrsWkt, NamesTheHorizontalSystemAndWhatHeightsCountFrom) {
  EXPECT_EQ(crsWkt(32632, HeightDatum::kUnknown).rfind("PROJCS[", 0), 0u);
  EXPECT_NE(crsWkt(32632, HeightDatum::kUnknown).find("\"32632\""), std::string::npos);
  const std::string msl = crsWkt(32756, HeightDatum::kMsl);
  EXPECT_EQ(msl.rfind("COMPD_CS[", 0), 0u);
  EXPECT_NE(msl.find("\"32756\""), std::string::npos);
  EXPECT_NE(msl.find("\"5714\""), std::string::npos);
  const std::string ellipsoid = crsWkt(32632, HeightDatum::kEllipsoid);
  EXPECT_EQ(ellipsoid.rfind("COMPD_CS[", 0), 0u);
  EXPECT_NE(ellipsoid.find("2002"), std::string::npos);
  EXPECT_THROW(crsWkt(4326, HeightDatum::kMsl), RunError);
  EXPECT_THROW(crsWkt(1, HeightDatum::kMsl), RunError);
}

/// GDAL's own tool takes the text for a valid system.
TEST(CrsWkt, IsUnderstoodByStockTools) {
  for (const HeightDatum datum :
       {HeightDatum::kUnknown, HeightDatum::kMsl, HeightDatum::kEllipsoid}) {
    const support::TempFolder folder;
    support::writeText(folder / "crs.wkt", crsWkt(32632, datum));
    const auto result =
        support::runCommand("gdalsrsinfo -V -o epsg '" + (folder / "crs.wkt").string() + "'");
    if (result.status == 127) GTEST_SKIP() << "gdalsrsinfo is not installed";
    EXPECT_EQ(result.status, 0) << result.output;
    EXPECT_NE(result.output.find("Validate Succeeds"), std::string::npos) << result.output;
  }
}

}  // namespace
}  // namespace cf
