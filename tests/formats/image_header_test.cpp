// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/image_header.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

namespace cf {
namespace {

std::vector<std::uint8_t> encoded(const char* extension, int width, int height) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(extension, cv::Mat(height, width, CV_8UC3, cv::Scalar(1, 2, 3)), bytes);
  return bytes;
}

TEST(ImageHeader, TellsTheSizeOfWhatOpenCvWrites) {
  for (const char* extension : {".jpg", ".png", ".tif"}) {
    const auto bytes = encoded(extension, 321, 17);
    const auto size = imageSizeOf(bytes.data(), bytes.size());
    ASSERT_TRUE(size) << extension;
    EXPECT_EQ(size->width, 321u) << extension;
    EXPECT_EQ(size->height, 17u) << extension;
  }
}

TEST(ImageHeader, LooksPastTheTagsAndThePreviewOfAJpeg) {
  auto bytes = encoded(".jpg", 30, 20);
  const auto preview = encoded(".jpg", 8, 6);
  std::vector<std::uint8_t> segment = {0xFF, 0xE1, 0, 0};
  segment.insert(segment.end(), preview.begin(), preview.end());
  segment[2] = static_cast<std::uint8_t>((segment.size() - 2) >> 8);
  segment[3] = static_cast<std::uint8_t>((segment.size() - 2) & 0xFF);
  bytes.insert(bytes.begin() + 2, segment.begin(), segment.end());
  ASSERT_TRUE(imageSizeOf(bytes.data(), bytes.size()));
  EXPECT_EQ(imageSizeOf(bytes.data(), bytes.size())->width, 30u);
}

TEST(ImageHeader, BelievesTheHeaderHoweverLarge) {
  auto bytes = encoded(".png", 5, 4);
  bytes[18] = 0xEA, bytes[19] = 0x60;  // 60000
  EXPECT_EQ(imageSizeOf(bytes.data(), bytes.size())->width, 60000u);
}

TEST(ImageHeader, HasNoneForAnythingElse) {
  const std::string text = "Dear all, this is no photo.";
  EXPECT_FALSE(imageSizeOf(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
  EXPECT_FALSE(imageSizeOf(nullptr, 0));
  for (const char* extension : {".jpg", ".png", ".tif"}) {
    const auto bytes = encoded(extension, 321, 17);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      const auto told = imageSizeOf(bytes.data(), size);
      if (told && told->width == 321u && told->height == 17u) continue;
      // Cut inside a number: at most what is left of it.
      if (told) {
        EXPECT_LE(told->width, 321u) << extension << size;
      }
    }
  }
}

}  // namespace
}  // namespace cf
