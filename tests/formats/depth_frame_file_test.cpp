// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/depth_frame_file.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <cstring>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "cf/base/error.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

DepthFrame exampleFrame() {
  DepthFrame frame;
  frame.reference = {3, 70'000};
  frame.partner = {1, 12};
  frame.reference_view = {Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY()).toRotationMatrix(),
                          812.25,
                          99.5,
                          -12.125,
                          160,
                          120};
  frame.partner_view = {Eigen::AngleAxisd(1.3, Eigen::Vector3d::UnitX()).toRotationMatrix(),
                        812.25,
                        140.5,
                        -12.125,
                        200,
                        120};
  frame.reference_camera.width = 4000;
  frame.reference_camera.height = 3000;
  frame.reference_camera.fx = frame.reference_camera.fy = 2400.125;
  frame.reference_camera.k1 = -0.02;
  frame.reference_camera.version = 7;
  frame.partner_camera = frame.reference_camera;
  frame.partner_camera.k3 = 1e-3;
  frame.T_reference_partner.translation() << 10, -1e-17, 0.25;
  frame.disparity_offset_px = -41;
  frame.disparity.create(120, 160, CV_16U);
  frame.confidence.create(120, 160, CV_8U);
  frame.colour.create(120, 160, CV_8UC3);
  for (int v = 0; v < 120; ++v) {
    for (int u = 0; u < 160; ++u) {
      frame.disparity.at<ushort>(v, u) = u % 7 == 0 ? 0 : static_cast<ushort>(60'000 + v - 3 * u);
      frame.confidence.at<uchar>(v, u) = static_cast<uchar>(u + v);
      frame.colour.at<cv::Vec3b>(v, u) = {static_cast<uchar>(u), static_cast<uchar>(v), 90};
    }
  }
  return frame;
}

bool same(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

TEST(DepthFrameFile, keepsEverythingButTheLastBitsOfColour) {
  const support::TempFolder folder;
  const DepthFrame written = exampleFrame();
  writeDepthFrame(folder / "a.depth", written);
  const DepthFrame read = readDepthFrame(folder / "a.depth");

  EXPECT_EQ(read.reference, written.reference);
  EXPECT_EQ(read.partner, written.partner);
  EXPECT_EQ(read.reference_view.R_rect_cam, written.reference_view.R_rect_cam);
  EXPECT_EQ(read.partner_view.R_rect_cam, written.partner_view.R_rect_cam);
  EXPECT_EQ(read.reference_view.f, written.reference_view.f);
  EXPECT_EQ(read.partner_view.cx, written.partner_view.cx);
  EXPECT_EQ(read.partner_view.cy, written.partner_view.cy);
  EXPECT_EQ(read.partner_view.width, written.partner_view.width);
  EXPECT_EQ(read.reference_camera.fx, written.reference_camera.fx);
  EXPECT_EQ(read.reference_camera.version, written.reference_camera.version);
  EXPECT_EQ(read.partner_camera.k3, written.partner_camera.k3);
  EXPECT_EQ(read.T_reference_partner.matrix(), written.T_reference_partner.matrix());
  EXPECT_EQ(read.disparity_offset_px, written.disparity_offset_px);
  EXPECT_TRUE(same(read.disparity, written.disparity));
  EXPECT_TRUE(same(read.confidence, written.confidence));
  EXPECT_LT(cv::norm(read.colour, written.colour, cv::NORM_L1) / (3.0 * 120 * 160), 3.0);
}

/// Values of any kind: steps over the whole range, confidence where nothing matched and none where
/// something did.
DepthFrame wildFrame(cv::Size size) {
  DepthFrame frame = exampleFrame();
  frame.reference_view.width = size.width;
  frame.reference_view.height = size.height;
  frame.disparity.create(size, CV_16U);
  frame.confidence.create(size, CV_8U);
  frame.colour.create(size, CV_8UC3);
  std::mt19937 random(7);
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      const auto bits = random();
      frame.disparity.at<ushort>(v, u) =
          bits % 5 == 0 ? 0 : static_cast<ushort>(bits % 3 == 0 ? bits >> 16 : 4000 + (bits >> 24));
      frame.confidence.at<uchar>(v, u) = static_cast<uchar>(bits >> 8);
      frame.colour.at<cv::Vec3b>(v, u) = {90, 80, static_cast<uchar>(bits >> 4)};
    }
  }
  return frame;
}

TEST(DepthFrameFile, needsNoColour) {
  DepthFrame frame = exampleFrame();
  frame.colour.release();
  const DepthFrame back = decodeDepthFrame(encodeDepthFrame(frame), "here");
  EXPECT_TRUE(back.colour.empty());
  EXPECT_EQ(cv::norm(back.disparity, frame.disparity, cv::NORM_INF), 0);
}

TEST(DepthFrameFile, losesNoDisparityOfAnyKind) {
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(1, 40), cv::Size(40, 1), cv::Size(97, 61)}) {
    const DepthFrame written = wildFrame(size);
    const DepthFrame read = decodeDepthFrame(encodeDepthFrame(written), "test");
    EXPECT_TRUE(same(read.disparity, written.disparity));
    EXPECT_TRUE(same(read.confidence, written.confidence));
    EXPECT_EQ(read.colour.size(), size);
  }
}

TEST(DepthFrameFile, isAQuarterOfItsPixelsWhereTheSurfaceIsSmooth) {
  DepthFrame frame = exampleFrame();
  frame.confidence.setTo(200);
  frame.colour.setTo(cv::Scalar(80, 90, 100));
  EXPECT_LT(encodeDepthFrame(frame).size(), frame.disparity.total() / 4);
}

TEST(DepthFrameFile, trustsNoLengthEvenIfTheChecksumIsRight) {
  const std::string bytes = encodeDepthFrame(wildFrame({24, 16}));
  const std::size_t start_of_scan = bytes.rfind("\xFF\xDA");  // after it there are no lengths
  int refused = 0;
  for (std::size_t at = 8; at < start_of_scan; ++at) {
    for (const int value : {0x00, 0x7F, 0xFF}) {
      std::string changed = bytes.substr(0, bytes.size() - 4);
      changed[at] = static_cast<char>(value);
      const auto crc = static_cast<std::uint32_t>(
          crc32_z(0, reinterpret_cast<const Bytef*>(changed.data()), changed.size()));
      changed.append(reinterpret_cast<const char*>(&crc), sizeof crc);
      try {
        const DepthFrame read = decodeDepthFrame(changed, "test");
        EXPECT_EQ(read.disparity.size(), read.colour.size());
        EXPECT_EQ(read.disparity.size(), read.confidence.size());
      } catch (const RunError&) {
        ++refused;
      }
    }
  }
  EXPECT_GT(refused, 100);
}

TEST(DepthFrameFile, isNoneToOneWhoOnlyTries) {
  const support::TempFolder folder;
  EXPECT_FALSE(tryReadDepthFrame(folder / "none.depth"));
  EXPECT_FALSE(tryReadDepthFrame(folder.path()));
  const std::string bytes = encodeDepthFrame(exampleFrame());
  support::writeText(folder / "a.depth", bytes.substr(0, bytes.size() - 1));
  EXPECT_FALSE(tryReadDepthFrame(folder / "a.depth"));
  support::writeText(folder / "a.depth", bytes);
  const auto read = tryReadDepthFrame(folder / "a.depth");
  ASSERT_TRUE(read);
  EXPECT_TRUE(same(read->disparity, exampleFrame().disparity));
}

TEST(DepthFrameFile, refusesDamageNamingTheFile) {
  const support::TempFolder folder;
  const std::string bytes = encodeDepthFrame(exampleFrame());
  std::string flipped = bytes;
  flipped[bytes.size() / 2] = static_cast<char>(flipped[bytes.size() / 2] ^ 1);
  for (const std::string& bad :
       {flipped, bytes.substr(0, bytes.size() - 1), bytes.substr(0, 40), std::string(), bytes + "x",
        std::string("not a depth frame at all")}) {
    support::writeText(folder / "bad.depth", bad);
    try {
      readDepthFrame(folder / "bad.depth");
      FAIL() << "accepted " << bad.size() << " bytes";
    } catch (const RunError& error) {
      EXPECT_NE(std::string(error.what()).find("bad.depth"), std::string::npos);
    }
  }
  EXPECT_THROW(readDepthFrame(folder / "none.depth"), RunError);
  EXPECT_THROW(writeDepthFrame(folder / "no/such/folder.depth", exampleFrame()), RunError);
}

}  // namespace
}  // namespace cf
