// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/jpeg.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "cf/base/error.h"

namespace cf {
namespace {

cv::Mat picture(cv::Size size) {
  cv::Mat image(size, CV_8UC3);
  cv::RNG random(7);
  random.fill(image, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(image, image, {0, 0}, 2);
  return image;
}

std::vector<std::uint8_t> coded(const cv::Mat& image, int quality) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(".jpg", image, bytes, {cv::IMWRITE_JPEG_QUALITY, quality});
  return bytes;
}

bool same(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

TEST(Jpeg, PixelsAreThoseOfOpencv) {
  for (const cv::Size size : {cv::Size(333, 217), cv::Size(64, 48), cv::Size(1, 1)}) {
    const auto bytes = coded(picture(size), 90);
    const std::pair<int, int> reductions[] = {{1, cv::IMREAD_COLOR},
                                              {2, cv::IMREAD_REDUCED_COLOR_2},
                                              {4, cv::IMREAD_REDUCED_COLOR_4},
                                              {8, cv::IMREAD_REDUCED_COLOR_8}};
    for (const auto& [reduction, flag] : reductions)
      EXPECT_TRUE(same(decodeJpeg(bytes.data(), bytes.size(), reduction),
                       cv::imdecode(bytes, flag | cv::IMREAD_IGNORE_ORIENTATION)))
          << size << " / " << reduction;
  }
}

TEST(Jpeg, BytesAreThoseOfOpencv) {
  const cv::Mat whole = picture({203, 101});
  for (const cv::Mat& image : {whole, whole(cv::Rect(7, 3, 50, 61))}) {
    const auto wanted = coded(image, 95);
    EXPECT_EQ(encodeJpeg(image, 95), std::string(wanted.begin(), wanted.end()));
  }
}

TEST(Jpeg, GreyBecomesColour) {
  cv::Mat grey;
  cv::cvtColor(picture({80, 60}), grey, cv::COLOR_BGR2GRAY);
  const auto bytes = coded(grey, 90);
  const cv::Mat decoded = decodeJpeg(bytes.data(), bytes.size());
  EXPECT_TRUE(same(decoded, cv::imdecode(bytes, cv::IMREAD_COLOR)));
}

TEST(Jpeg, WhatCannotBeDecodedIsEmpty) {
  auto bytes = coded(picture({80, 60}), 90);
  EXPECT_TRUE(decodeJpeg(bytes.data(), 0).empty());
  EXPECT_TRUE(decodeJpeg(bytes.data(), 10).empty());
  const std::vector<std::uint8_t> png = {0x89, 'P', 'N', 'G', 0, 0, 0, 0};
  EXPECT_TRUE(decodeJpeg(png.data(), png.size()).empty());
  for (std::size_t at = 2; at < 600; at += 3) {  // whatever it does, it comes back
    auto broken = bytes;
    broken[at] ^= 0x55;
    decodeJpeg(broken.data(), broken.size(), 2);
  }
}

TEST(Jpeg, OneThatBreaksOffKeepsItsSize) {
  const auto bytes = coded(picture({80, 60}), 90);
  EXPECT_EQ(decodeJpeg(bytes.data(), bytes.size() / 2).size(), cv::Size(80, 60));
}

TEST(Jpeg, NothingCannotBeCoded) { EXPECT_THROW(encodeJpeg(cv::Mat(0, 0, CV_8UC3), 90), RunError); }

}  // namespace
}  // namespace cf
