// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/ply.h"

#include <gtest/gtest.h>

#include <cstring>

#include "cf/base/error.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

template <class T>
std::string bytes(T value) {
  std::string text(sizeof(T), 0);
  std::memcpy(text.data(), &value, sizeof(T));
  return text;
}

class Ply : public ::testing::Test {
 protected:
  fs::path fileWith(const std::string& content) const {
    support::writeText(folder_ / "read.ply", content);
    return folder_ / "read.ply";
  }

  support::TempFolder folder_;
};

TEST_F(Ply, WhatIsWrittenIsRead) {
  const fs::path path = folder_ / "written.ply";
  PlyWriter writer(path);
  for (int i = 0; i < 1234; ++i)
    writer.add({0.5F * static_cast<float>(i), -1, 7},
               {static_cast<std::uint8_t>(i % 256), 100, 255});
  EXPECT_EQ(writer.count(), 1234u);
  writer.close();
  const PlyReader header(path);
  EXPECT_EQ(header.count(), 1234u);
  EXPECT_TRUE(header.coloured());
  const std::vector<PlyPoint> points = readPly(path);
  ASSERT_EQ(points.size(), 1234u);
  EXPECT_EQ(points[1001].position_m, Eigen::Vector3d(500.5, -1, 7));
  EXPECT_EQ(points[1001].rgb, (std::array<std::uint8_t, 3>{1001 % 256, 100, 255}));
}

TEST_F(Ply, TheContractsLayoutByteForByte) {
  const fs::path path = folder_ / "layout.ply";
  PlyWriter writer(path);
  writer.add({1, 2, 3}, {4, 5, 6});
  writer.close();
  const std::string text = support::fileText(path);
  const std::string body = bytes(1.F) + bytes(2.F) + bytes(3.F) + "\4\5\6";
  EXPECT_EQ(text.rfind("ply\nformat binary_little_endian 1.0\nelement vertex 1\n", 0), 0u);
  const std::string end =
      "property float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n" +
      body;
  ASSERT_GT(text.size(), end.size());
  EXPECT_EQ(text.substr(text.size() - end.size()), end);
}

TEST_F(Ply, AnyOrderDoublesListsAndElementsBefore) {
  const std::string header =
      "ply\nformat binary_little_endian 1.0\ncomment by hand\nelement face 1\n"
      "property list uchar int vertex_indices\nelement vertex 2\nproperty uchar blue\n"
      "property double z\nproperty list ushort float extra\nproperty double x\n"
      "property float confidence\nproperty double y\nproperty uchar green\nproperty uchar red\n"
      "end_header\n";
  const std::string face = bytes<std::uint8_t>(3) + bytes(0) + bytes(1) + bytes(1);
  const auto vertex = [](double x, std::uint16_t extra) {
    std::string v = bytes<std::uint8_t>(30) + bytes(x + 2) + bytes(extra);
    for (int i = 0; i < extra; ++i) v += bytes(9.F);
    return v + bytes(x) + bytes(0.5F) + bytes(x + 1) + bytes<std::uint8_t>(20) +
           bytes<std::uint8_t>(10);
  };
  const auto points = readPly(fileWith(header + face + vertex(5e5 + 0.001, 2) + vertex(4, 0)));
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[0].position_m, Eigen::Vector3d(5e5 + 0.001, 5e5 + 0.001 + 1, 5e5 + 0.001 + 2));
  EXPECT_EQ(points[1].position_m, Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(points[1].rgb, (std::array<std::uint8_t, 3>{10, 20, 30}));
}

TEST_F(Ply, Ascii) {
  const auto points =
      readPly(fileWith("ply\r\nformat ascii 1.0\r\nelement vertex 2\r\nproperty float x\r\n"
                       "property float y\r\nproperty float z\r\nproperty float red\r\n"
                       "property float green\r\nproperty float blue\r\nend_header\r\n"
                       "1 2 3 1 0.5 0\r\n-4 5e1 6 0 0 0\r\n"));
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[0].rgb, (std::array<std::uint8_t, 3>{255, 128, 0}));
  EXPECT_EQ(points[1].position_m, Eigen::Vector3d(-4, 50, 6));
}

TEST_F(Ply, BadFilesAreNamed) {
  const std::string xyz = "property float x\nproperty float y\nproperty float z\nend_header\n";
  for (const std::string& content :
       {std::string("nonsense"), std::string("ply\nformat ascii 1.0\nelement vertex 1\n"),
        "ply\nformat binary_big_endian 1.0\nelement vertex 1\n" + xyz,
        "ply\nformat ascii 1.0\nelement face 1\n" + xyz,
        "ply\nformat ascii 1.0\nelement vertex 2\n" + xyz + "1 2 3\n",
        "ply\nformat binary_little_endian 1.0\nelement vertex 1\n" + xyz + "12345",
        std::string("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n"),
        std::string("ply\nformat ascii 1.0\nelement vertex 1\nproperty half x\nend_header\n1\n")})
    EXPECT_THROW(static_cast<void>(readPly(fileWith(content))), RunError) << content;
  EXPECT_THROW(static_cast<void>(readPly("/nonexistent.ply")), RunError);
}

}  // namespace
}  // namespace cf
