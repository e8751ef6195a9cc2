// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "photo_crops.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <stdexcept>
#include <utility>

namespace cf {
namespace {

CameraModel camera() {
  CameraModel c;
  c.width = 200;
  c.height = 100;
  c.fx = c.fy = 150;
  return c;
}

/// Half the size; each pixel tells its photo and its place.
cv::Mat photo(std::size_t number) {
  cv::Mat image(50, 100, CV_8UC3);
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x)
      image.at<cv::Vec3b>(y, x) = {static_cast<std::uint8_t>(number), static_cast<std::uint8_t>(x),
                                   static_cast<std::uint8_t>(y)};
  return image;
}

class PhotoCropsOfTwo : public ::testing::Test {
 protected:
  PhotoCrops crops(std::size_t budget_bytes) {
    const PhotoCrops::Parts parts = {{0, {20, 20, 40, 20}}, {1, {100, 10, 20, 20}}};
    return {[this](std::size_t i) {
              ++decoded_;
              return photo(i);
            },
            {camera(), camera()},
            {parts, parts},
            budget_bytes};
  }
  int decoded_ = 0;
};

TEST_F(PhotoCropsOfTwo, APhotoIsDecodedOnceForAllWindows) {
  PhotoCrops some = crops(1 << 20);
  const PhotoCrop a = some.get(1, 0);
  EXPECT_EQ(a.camera.width, 100);
  // The part asked for and some pixels around it, where it says.
  EXPECT_LE(a.corner.x, 10);
  EXPECT_GE(a.corner.x + a.image.cols, 30);
  EXPECT_LT(a.image.cols, 40);
  EXPECT_EQ(a.image.at<cv::Vec3b>(3, 4), cv::Vec3b(1, static_cast<std::uint8_t>(a.corner.x + 4),
                                                   static_cast<std::uint8_t>(a.corner.y + 3)));
  EXPECT_FALSE(some.get(1, 1).image.empty());
  EXPECT_EQ(decoded_, 1);
  EXPECT_FALSE(some.get(0, 0).image.empty());
  EXPECT_EQ(decoded_, 2);
}

TEST_F(PhotoCropsOfTwo, WhatThereIsNoRoomForIsDecodedAgain) {
  PhotoCrops some = crops(1);
  EXPECT_FALSE(some.get(0, 0).image.empty());
  EXPECT_FALSE(some.get(1, 0).image.empty());  // drives out the rest of photo 0
  EXPECT_FALSE(some.get(0, 1).image.empty());
  EXPECT_EQ(decoded_, 3);
}

TEST(PhotoCrops, ADecoderThatFailsOnceKeepsNobodyWaiting) {
  bool failed = false;
  PhotoCrops some(
      [&](std::size_t i) {
        if (!std::exchange(failed, true)) throw std::runtime_error("no memory");
        return photo(i);
      },
      {camera()}, {{{0, {20, 20, 40, 20}}}}, 1 << 20);
  EXPECT_THROW(some.get(0, 0), std::runtime_error);
  EXPECT_FALSE(some.get(0, 0).image.empty());
}

TEST(PhotoCrops, APhotoThatCannotBeReadHasNoImage) {
  PhotoCrops none([](std::size_t) { return cv::Mat(); }, {camera()}, {{{0, {0, 0, 9, 9}}}}, 99);
  EXPECT_TRUE(none.get(0, 0).image.empty());
}

}  // namespace
}  // namespace cf
