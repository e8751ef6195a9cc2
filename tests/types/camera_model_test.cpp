// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/types/camera_model.h"

#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>
#include <random>
#include <vector>

namespace cf {
namespace {

/// Whether the distortion grows outward all the way to the corners, as a lens does.
bool isLens(const CameraModel& c) {
  const double corner = Eigen::Vector2d(c.width / c.fx, c.height / c.fy).norm() / 2 + 0.05;
  double last = 0;
  for (double r = 0.01; last < corner; r += 0.01) {
    const double distorted = r * (1 + r * r * (c.k1 + r * r * (c.k2 + r * r * c.k3)));
    if (distorted < last + 0.002) return false;
    last = distorted;
  }
  return true;
}

/// A camera as drones have them: 50 to 85 degrees wide, Brown distortion of either sign.
CameraModel randomCamera(std::mt19937& random) {
  const auto draw = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  CameraModel c;
  c.width = 800 + 2 * static_cast<int>(draw(0, 2000));
  c.height = c.width * 3 / 4;
  c.fx = c.width * draw(0.55, 1.0);
  c.fy = c.fx * draw(0.99, 1.01);
  c.cx = c.width / 2.0 + draw(-20, 20);
  c.cy = c.height / 2.0 + draw(-20, 20);
  do {
    c.k1 = draw(-0.3, 0.2);
    c.k2 = draw(-0.1, 0.15);
    c.k3 = draw(-0.03, 0.03);
  } while (!isLens(c));
  c.p1 = draw(-0.002, 0.002);
  c.p2 = draw(-0.002, 0.002);
  c.focal_sigma = 0.05 * c.fx;
  c.version = 3;
  return c;
}

Eigen::Vector2d randomPixel(const CameraModel& c, std::mt19937& random) {
  return {std::uniform_real_distribution<double>(-0.5, c.width - 0.5)(random),
          std::uniform_real_distribution<double>(-0.5, c.height - 0.5)(random)};
}

TEST(CameraModel, projectsAsOpenCvDoes) {
  std::mt19937 random(1);
  for (int i = 0; i < 200; ++i) {
    const CameraModel c = randomCamera(random);
    const cv::Matx33d K(c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1);
    const std::vector<double> distortion = {c.k1, c.k2, c.p1, c.p2, c.k3};
    const Eigen::Vector2d n = c.undistort(randomPixel(c, random));
    const double depth = std::uniform_real_distribution<double>(1, 200)(random);
    const cv::Point3d point(n.x() * depth, n.y() * depth, depth);
    std::vector<cv::Point2d> expected;
    cv::projectPoints(std::vector<cv::Point3d>{point}, cv::Vec3d(), cv::Vec3d(), K, distortion,
                      expected);
    const Eigen::Vector2d pixel = c.project({point.x, point.y, point.z});
    EXPECT_NEAR(pixel.x(), expected[0].x, 1e-8);
    EXPECT_NEAR(pixel.y(), expected[0].y, 1e-8);
  }
}

TEST(CameraModel, undistortInvertsDistortOverTheWholePhoto) {
  std::mt19937 random(2);
  for (int i = 0; i < 2000; ++i) {
    const CameraModel c = randomCamera(random);
    Eigen::Vector2d pixel = randomPixel(c, random);
    if (i % 4 == 0) pixel = {c.width - 0.5, c.height - 0.5};  // a corner, where it bends most
    EXPECT_LT((c.distort(c.undistort(pixel)) - pixel).norm(), 1e-9 * c.fx)
        << "k1 " << c.k1 << " k2 " << c.k2 << " k3 " << c.k3;
  }
}

TEST(CameraModel, withoutDistortionItIsThePinhole) {
  CameraModel c;
  c.width = 100;
  c.height = 80;
  c.fx = c.fy = 90;
  c.cx = 49.5;
  c.cy = 39.5;
  EXPECT_EQ(c.project({0, 0, 5}), Eigen::Vector2d(49.5, 39.5));
  EXPECT_EQ(c.project({1, 2, 10}), Eigen::Vector2d(49.5 + 9, 39.5 + 18));
  EXPECT_EQ(c.undistort({139.5, 39.5}), Eigen::Vector2d(1, 0));
}

TEST(CameraModel, resizingMovesEveryPointWithItsPhoto) {
  std::mt19937 random(3);
  for (int i = 0; i < 200; ++i) {
    const CameraModel c = randomCamera(random);
    const int width = 100 + static_cast<int>(random() % 5000);
    const int height = 100 + static_cast<int>(random() % 5000);
    const CameraModel s = c.scaled(width, height);
    EXPECT_EQ(s.width, width);
    EXPECT_EQ(s.height, height);
    EXPECT_EQ(s.version, c.version);
    // The photo's area [-0.5, width - 0.5) is stretched: its corners stay its corners.
    const Eigen::Vector2d pixel = randomPixel(c, random);
    const Eigen::Vector2d expected((pixel.x() + 0.5) * width / c.width - 0.5,
                                   (pixel.y() + 0.5) * height / c.height - 0.5);
    EXPECT_LT((s.distort(c.undistort(pixel)) - expected).norm(), 1e-5);
    EXPECT_NEAR(s.focal_sigma / s.fx, c.focal_sigma / c.fx, 1e-12);
    const CameraModel back = s.scaled(c.width, c.height);
    EXPECT_NEAR(back.fx, c.fx, 1e-9);
    EXPECT_NEAR(back.cy, c.cy, 1e-9);
  }
}

TEST(CameraModel, containsThePixelsUpToTheirOuterEdges) {
  CameraModel c;
  c.width = 10;
  c.height = 8;
  EXPECT_TRUE(c.contains({-0.5, -0.5}));
  EXPECT_TRUE(c.contains({9.49, 7.49}));
  EXPECT_FALSE(c.contains({9.5, 0}));
  EXPECT_FALSE(c.contains({0, 7.5}));
  EXPECT_FALSE(c.contains({-0.51, 0}));
  EXPECT_FALSE(c.contains({0, -0.51}));
}

}  // namespace
}  // namespace cf
