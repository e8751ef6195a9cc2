// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/pcd.h"

#include <gtest/gtest.h>

#include <cstring>
#include <string>

#include "cf/base/error.h"
#include "support/message_of.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

template <class T>
std::string raw(T value) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  return bytes;
}

Tile twoPoints() {
  Tile tile;
  tile.index = {-3, 4};
  tile.offset_m = {-150.1, 200, 1.0 / 3};
  TilePoint a;
  a.position_m = {0.1f, 49.99f, -12.5f};
  a.bgr[0] = 10, a.bgr[1] = 20, a.bgr[2] = 255;
  a.views = 65535;
  a.confidence = 3.25e-7f;
  tile.points = {a, TilePoint{}};
  return tile;
}

class Pcd : public ::testing::Test {
 protected:
  support::TempFolder folder_;
};

TEST_F(Pcd, HeaderAndRecordAreWhatPclExpects) {
  const fs::path file = folder_ / "layout.pcd";
  writePcd(file, twoPoints());
  const std::string bytes = support::fileText(file);
  const std::string marker = "DATA binary\n";
  const std::size_t start = bytes.find(marker) + marker.size();
  const std::string header = bytes.substr(0, start);
  EXPECT_NE(header.find("VERSION 0.7\nFIELDS x y z rgb confidence views\nSIZE 4 4 4 4 4 2\n"
                        "TYPE F F F F F U\nCOUNT 1 1 1 1 1 1\nWIDTH 2\nHEIGHT 1\n"
                        "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA binary\n"),
            std::string::npos);
  const std::string first = raw(0.1f) + raw(49.99f) + raw(-12.5f) + raw(std::uint32_t{0x00FF140A}) +
                            raw(3.25e-7f) + raw(std::uint16_t{65535});
  EXPECT_EQ(bytes.substr(start), first + std::string(22, '\0'));
}

TEST_F(Pcd, RoundTripIsExact) {
  const fs::path file = folder_ / "round.pcd";
  const Tile tile = twoPoints();
  writePcd(file, tile);
  const Tile back = readPcd(file);
  EXPECT_EQ(back.offset_m, tile.offset_m);
  ASSERT_EQ(back.points.size(), tile.points.size());
  for (std::size_t i = 0; i < tile.points.size(); ++i) {
    EXPECT_EQ(back.points[i].position_m, tile.points[i].position_m);
    EXPECT_EQ(0, std::memcmp(back.points[i].bgr, tile.points[i].bgr, 3));
    EXPECT_EQ(back.points[i].views, tile.points[i].views);
    EXPECT_EQ(back.points[i].confidence, tile.points[i].confidence);
  }
  EXPECT_FALSE(fs::exists(file.string() + ".tmp"));
}

TEST_F(Pcd, EmptyTile) {
  const fs::path file = folder_ / "empty.pcd";
  writePcd(file, Tile{});
  EXPECT_TRUE(readPcd(file).points.empty());
}

TEST_F(Pcd, FieldsAreFoundByNameInAnyOrder) {
  const fs::path file = folder_ / "foreign.pcd";
  support::writeText(file,
                     "VERSION 0.7\nFIELDS z normal rgb y x\nSIZE 4 4 4 4 4\nTYPE F F U F F\n"
                     "COUNT 1 3 1 1 1\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA binary\n" +
                         raw(3.f) + raw(9.f) + raw(9.f) + raw(9.f) + raw(std::uint32_t{0x112233}) +
                         raw(2.f) + raw(1.f));
  const Tile tile = readPcd(file);
  ASSERT_EQ(tile.points.size(), 1u);
  EXPECT_EQ(tile.points[0].position_m, Eigen::Vector3f(1, 2, 3));
  EXPECT_EQ(tile.points[0].bgr[0], 0x33);
  EXPECT_EQ(tile.points[0].bgr[2], 0x11);
  EXPECT_EQ(tile.points[0].views, 0);
}

TEST_F(Pcd, BadFilesAreNamed) {
  const fs::path file = folder_ / "bad.pcd";
  const auto messageOf = [&](const std::string& bytes) -> std::string {
    support::writeText(file, bytes);
    return support::messageOf<RunError>([&] { readPcd(file); });
  };
  writePcd(file, twoPoints());
  const std::string good = support::fileText(file);
  const std::string cut = messageOf(good.substr(0, good.size() - 1));
  EXPECT_NE(cut.find("bad.pcd: cannot be read: cut short"), std::string::npos) << cut;
  EXPECT_NE(messageOf("").find("not a PCD file"), std::string::npos);
  EXPECT_NE(
      messageOf("FIELDS x y\nSIZE 4 4\nTYPE F F\nCOUNT 1 1\nPOINTS 0\nDATA binary\n").find("\"z\""),
      std::string::npos);
  EXPECT_NE(messageOf("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 1\nDATA ascii\n1 2 3\n")
                .find("ascii"),
            std::string::npos);
  const std::string huge = messageOf(
      "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nPOINTS 99999999999999\nDATA binary\n");
  EXPECT_NE(huge.find("cut short"), std::string::npos) << huge;
  EXPECT_THROW(readPcd(folder_ / "absent.pcd"), RunError);
  EXPECT_THROW(writePcd(folder_ / "no/such/folder.pcd", Tile{}), RunError);
}

}  // namespace
}  // namespace cf
