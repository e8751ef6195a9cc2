// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/gcp_list.h"

#include <gtest/gtest.h>

#include "cf/base/error.h"
#include "support/message_of.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

class GcpListFile : public ::testing::Test {
 protected:
  GcpList read(const std::string& text) {
    support::writeText(path_, text);
    return readGcpList(path_);
  }
  std::string errorOf(const std::string& text) {
    return support::messageOf<UsageError>([&] { read(text); });
  }
  support::TempFolder folder_;
  const std::filesystem::path path_ = folder_ / "gcp_list.txt";
};

TEST_F(GcpListFile, MarksOfOnePlaceAreOnePoint) {
  const GcpList list = read(
      "\xEF\xBB\xBF+proj=utm +zone=17 +datum=WGS84\r\n"
      "333158.2 3102916.18 3\t539.886 333.744 DJI_0065.JPG\r\n"
      "\n# the second\n"
      "333187.62 3102954.46 3 1 2 DJI_0065.JPG # here\n"
      "333158.20 3102916.18 3.0 541 392 s1/DJI_0066.JPG\n");
  EXPECT_EQ(list.crs, "+proj=utm +zone=17 +datum=WGS84");
  ASSERT_EQ(list.points.size(), 2u);
  const GroundControlPoint& first = list.points[0];
  EXPECT_EQ(first.name, "1");
  EXPECT_EQ(first.surveyed, Eigen::Vector3d(333158.2, 3102916.18, 3));
  ASSERT_EQ(first.marks.size(), 2u);
  EXPECT_EQ(first.marks[0].image, "DJI_0065.JPG");
  EXPECT_EQ(first.marks[0].pixel, Eigen::Vector2d(539.886, 333.744));
  EXPECT_EQ(first.marks[1].image, "s1/DJI_0066.JPG");
  EXPECT_EQ(list.points[1].name, "2");
  ASSERT_EQ(list.points[1].marks.size(), 1u);
}

TEST_F(GcpListFile, NamesTellPointsApart) {
  const GcpList list = read(
      "EPSG:4326\n-91.99 46.8 198 10 20 a.jpg west\n-91.98 46.8 198 10 20 a.jpg east\n"
      "-91.99 46.8 198 12 20 b.jpg west\n");
  ASSERT_EQ(list.points.size(), 2u);
  EXPECT_EQ(list.points[0].name, "west");
  EXPECT_EQ(list.points[0].marks.size(), 2u);
  EXPECT_EQ(list.points[1].name, "east");
}

TEST_F(GcpListFile, ErrorsNameFileAndLine) {
  const std::string head = "EPSG:4326\n1 2 3 10 20 a.jpg p\n";
  EXPECT_NE(errorOf(head + "1 2 3 10 b.jpg\n").find("gcp_list.txt:3"), std::string::npos);
  EXPECT_NE(errorOf(head + "1 2 3 10 2x b.jpg\n").find("'2x'"), std::string::npos);
  EXPECT_NE(errorOf(head + "1 2 4 10 20 b.jpg p\n").find("another position"), std::string::npos);
  EXPECT_NE(errorOf(head + "1 2 3 11 21 a.jpg p\n").find("marked twice in a.jpg"),
            std::string::npos);
  EXPECT_NE(errorOf(head + "1 2 3 11 21 a b c.jpg p\n").find("was expected"), std::string::npos);
  EXPECT_NE(errorOf("EPSG:4326\n").find("marks no point"), std::string::npos);
  EXPECT_NE(errorOf("").find("marks no point"), std::string::npos);
  EXPECT_THROW(static_cast<void>(readGcpList(folder_ / "none.txt")), UsageError);
}

}  // namespace
}  // namespace cf
