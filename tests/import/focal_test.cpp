// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/import/focal.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cf {
namespace {

const double kDiagonal = std::hypot(36, 24);

TEST(Focal, FocalPlaneResolutionComesFirst) {
  const FocalEstimate f = focalOf({4.5, 25, 16393.4 / 25.4, 4000}, 4000, 3000);
  EXPECT_NEAR(f.focal_px, 4.5 * 16393.4 / 25.4, 1e-9);
  EXPECT_NEAR(f.sigma_px, 0.05 * f.focal_px, 1e-9);
  EXPECT_FALSE(f.assumed);
}

TEST(Focal, OfAReducedCopyIsInItsOwnPixels) {
  EXPECT_NEAR(focalOf({4.5, 0, 16393.4 / 25.4, 4000}, 1000, 750).focal_px, 4.5 * 16393.4 / 25.4 / 4,
              1e-9);
  EXPECT_NEAR(focalOf({3.61, 20, 0, 0}, 800, 600).focal_px, 20 / kDiagonal * 1000, 1e-6);
}

TEST(Focal, ACopyThatLostItsOriginalWidthFallsBackOn35mm) {
  // 800 px at 645 px/mm would be a sensor of 1.2 mm.
  EXPECT_NEAR(focalOf({4.5, 25, 16393.4 / 25.4, 800}, 800, 600).focal_px, 25 / kDiagonal * 1000,
              1e-6);
}

TEST(Focal, By35mmUsesTheDiagonalOfTheUncroppedSensor) {
  EXPECT_NEAR(focalOf({3.61, 20, 0, 0}, 4000, 3000).focal_px, 20 / kDiagonal * 5000, 1e-6);
  EXPECT_NEAR(focalOf({3.61, 20, 0, 0}, 4000, 2250).focal_px, 20 / kDiagonal * 5000, 1e-6)
      << "16:9 of the same sensor has the same focal length";
  EXPECT_NEAR(focalOf({3.61, 20, 0, 0}, 3000, 4000).focal_px, 20 / kDiagonal * 5000, 1e-6);
  EXPECT_NEAR(focalOf({8.8, 24, 0, 0}, 5472, 3648).focal_px,
              24 / kDiagonal * std::hypot(5472, 3648), 1e-6);
}

TEST(Focal, WithoutTagsItIsAssumedAndSaysSo) {
  const FocalEstimate f = focalOf({}, 1000, 750);
  EXPECT_TRUE(f.assumed);
  EXPECT_EQ(f.focal_px, 800);
  EXPECT_EQ(f.sigma_px, 160);
}

TEST(Focal, CameraIsCentred) {
  const CameraModel camera = cameraFrom({900, 45, "", false}, 1000, 750);
  EXPECT_EQ(camera.fx, 900);
  EXPECT_EQ(camera.fy, 900);
  EXPECT_EQ(camera.cx, 499.5);
  EXPECT_EQ(camera.cy, 374.5);
  EXPECT_EQ(camera.focal_sigma, 45);
  EXPECT_GT(camera.k1_sigma, 0);
}

}  // namespace
}  // namespace cf
