// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "surface_grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/core.hpp>

namespace cf {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

/// One point in the middle of every cell.
std::vector<SurfacePoint> plane(int width, int height, float z, int from_x = 0) {
  std::vector<SurfacePoint> points;
  for (int y = 0; y < height; ++y)
    for (int x = from_x; x < width; ++x)
      points.push_back({static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F, z, 10, 4});
  return points;
}

TEST(SurfaceGrid, ARoofHidesTheGroundAndItsWallDoesNotDrawItDown) {
  auto points = plane(20, 20, 0);
  const auto roof = plane(20, 20, 50, 10);
  points.insert(points.end(), roof.begin(), roof.end());
  for (int y = 0; y < 20; ++y)
    for (int z = 1; z < 50; z += 3)
      points.push_back({10.2F, static_cast<float>(y) + 0.5F, static_cast<float>(z), 3, 2});
  const cv::Mat surface = uppermostSurface(points, {20, 20});
  for (int y = 0; y < 20; ++y) {
    EXPECT_FLOAT_EQ(surface.at<float>(y, 9), 0);  // the edge is where it is, not a ramp
    EXPECT_GT(surface.at<float>(y, 10), 49);
    EXPECT_NEAR(surface.at<float>(y, 11), 50, 0.1);
  }
}

TEST(SurfaceGrid, WhatFewSawAboveAWellSeenSurfaceDoesNotCount) {
  auto points = plane(9, 9, 5);
  points.push_back({4.5F, 4.5F, 25, 5, 0.9F});  // 0.9 of 4 views
  EXPECT_FLOAT_EQ(uppermostSurface(points, {9, 9}).at<float>(4, 4), 5);
  points.back().views = 4;  // a wire, a flagpole: but it stands alone
  EXPECT_TRUE(std::isnan(uppermostSurface(points, {9, 9}).at<float>(4, 4)));
}

TEST(SurfaceGrid, WeakPointsJustAboveASurfaceDoNotLiftIt) {
  auto points = plane(9, 9, 5);
  points.push_back({4.5F, 4.5F, 8.5F, 1, 1});
  EXPECT_NEAR(uppermostSurface(points, {9, 9}).at<float>(4, 4), 5, 1e-4);
}

TEST(SurfaceGrid, ASlopeStaysASlope) {
  std::vector<SurfacePoint> points;
  for (int y = 0; y < 12; ++y)
    for (int x = 0; x < 12; ++x)
      points.push_back({static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F,
                        1.5F * static_cast<float>(x), 1, 1});
  const cv::Mat surface = uppermostSurface(points, {12, 12});
  for (int x = 1; x < 11; ++x)
    EXPECT_NEAR(surface.at<float>(6, x), 1.5F * static_cast<float>(x), 1e-4);
}

TEST(SurfaceGrid, PointsOutsideDoNotCountAndCellsWithoutPointsHaveNoHeight) {
  auto points = plane(5, 5, 1);
  points.push_back({-0.1F, 2, 9, 1, 1});
  points.push_back({2, 7, 9, 1, 1});
  points.push_back({kNone, 2, 9, 1, 1});
  const cv::Mat surface = uppermostSurface(points, {7, 5});
  EXPECT_FLOAT_EQ(surface.at<float>(2, 2), 1);
  EXPECT_TRUE(std::isnan(surface.at<float>(2, 6)));
}

cv::Mat withHole(cv::Size size, const cv::Rect& hole) {
  cv::Mat heights(size, CV_32FC1, cv::Scalar(2));
  heights(hole).setTo(kNone);
  return heights;
}

TEST(SurfaceGrid, HolesAreFilledAsFarAsToldNotFurther) {
  const cv::Mat small = withHolesFilled(withHole({40, 40}, {10, 10, 5, 5}), 6, 8);
  EXPECT_EQ(cv::countNonZero(small != 2), 0);
  const cv::Mat large = withHolesFilled(withHole({60, 60}, {15, 15, 30, 30}), 6, 8);
  EXPECT_TRUE(std::isnan(large.at<float>(30, 30)));
  EXPECT_TRUE(std::isnan(large.at<float>(22, 30)));
}

TEST(SurfaceGrid, TheRimIsNotExtended) {
  const cv::Mat filled = withHolesFilled(withHole({40, 40}, {0, 0, 40, 10}), 6, 8);
  EXPECT_EQ(cv::countNonZero(filled(cv::Rect(0, 0, 40, 10)) == 2), 0);
}

// What photos from above do not see lies beside a roof.
TEST(SurfaceGrid, HolesBesideARoofAreGround) {
  cv::Mat heights(40, 40, CV_32FC1, cv::Scalar(2));
  heights(cv::Rect(20, 0, 20, 40)).setTo(52);
  heights(cv::Rect(16, 12, 4, 6)).setTo(kNone);
  const cv::Mat filled = withHolesFilled(heights, 6, 8);
  for (int y = 12; y < 18; ++y)
    for (int x = 16; x < 20; ++x) EXPECT_FLOAT_EQ(filled.at<float>(y, x), 2) << x << " " << y;
}

}  // namespace
}  // namespace cf
