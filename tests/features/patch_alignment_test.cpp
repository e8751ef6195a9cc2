// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/features/patch_alignment.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <opencv2/core.hpp>

namespace cf {
namespace {

/// A smooth texture with an exact value everywhere.
double texture(double x, double y) {
  return 128 + 35 * std::sin(0.31 * x + 0.2 * y) + 30 * std::cos(0.17 * x - 0.37 * y) +
         20 * std::sin(0.45 * y + 0.05 * x);
}

/// Pixel p of it shows the texture at A (p - shift), times gain.
cv::Mat view(const Eigen::Matrix2d& A, const Eigen::Vector2d& shift, double gain) {
  cv::Mat grey(120, 160, CV_8UC1);
  for (int y = 0; y < grey.rows; ++y)
    for (int x = 0; x < grey.cols; ++x) {
      const Eigen::Vector2d p = A * (Eigen::Vector2d(x, y) - shift);
      grey.at<unsigned char>(y, x) =
          cv::saturate_cast<unsigned char>(gain * texture(p.x(), p.y()) + 5);
    }
  return grey;
}

struct Case {
  Eigen::Matrix2d A;
  Eigen::Vector2d shift;
  double gain;
};

TEST(AlignPatch, FindsShiftTurnAndSlopeToHundredthsOfAPixel) {
  Eigen::Matrix2d turned, sloped;
  turned << std::cos(0.3), -std::sin(0.3), std::sin(0.3), std::cos(0.3);
  sloped << 1.08, 0.04, -0.05, 0.94;
  const cv::Mat reference = view(Eigen::Matrix2d::Identity(), {0, 0}, 1);
  for (const Case& c : {Case{Eigen::Matrix2d::Identity(), {4.37, -2.81}, 1},
                        Case{turned, {55.2, -8.6}, 0.8}, Case{sloped, {3.3, 2.6}, 0.9}}) {
    const cv::Mat target = view(c.A, c.shift, c.gain);
    for (const Eigen::Vector2d& at : {Eigen::Vector2d(70.4, 55.8), Eigen::Vector2d(61.9, 48.1)}) {
      const Eigen::Vector2d truth = c.A.inverse() * at + c.shift;
      // Told about the turn, as odometry is, but not about the slope.
      const Eigen::Matrix2d guess =
          c.A == sloped ? Eigen::Matrix2d::Identity() : Eigen::Matrix2d(c.A.inverse());
      const auto found =
          alignPatch(reference, at, target, truth + Eigen::Vector2d(0.7, -0.6), guess, 2);
      ASSERT_TRUE(found) << c.shift.transpose();
      EXPECT_LT((found->position - truth).norm(), 0.03) << c.shift.transpose();
      EXPECT_LT(found->sigma, 0.05);
    }
  }
}

TEST(AlignPatch, RefusesWhatDoesNotFit) {
  const cv::Mat reference = view(Eigen::Matrix2d::Identity(), {0, 0}, 1);
  const Eigen::Matrix2d same = Eigen::Matrix2d::Identity();
  const Eigen::Vector2d at(70, 55);
  ASSERT_TRUE(alignPatch(reference, at, reference, at, same, 2));
  EXPECT_FALSE(alignPatch(reference, {3, 3}, reference, {3, 3}, same, 2)) << "at the border";
  // Its last pixels lie a hair before the last of the photo, where floats cannot tell them apart.
  EXPECT_FALSE(
      alignPatch(reference, {149, 109}, view(same, {2, 2}, 1), {151 - 1e-8, 111 - 1e-8}, same, 2))
      << "beyond the last pixel";
  const cv::Mat blank(120, 160, CV_8UC1, cv::Scalar(90));
  EXPECT_FALSE(alignPatch(blank, at, blank, at, same, 2)) << "no texture";
  EXPECT_FALSE(alignPatch(reference, at, blank, at, same, 2)) << "nothing alike";
  cv::Mat other(120, 160, CV_8UC1);
  cv::RNG random(7);
  random.fill(other, cv::RNG::UNIFORM, 0, 255);
  EXPECT_FALSE(alignPatch(reference, at, other, at, same, 2)) << "another texture";
  const cv::Mat moved = view(same, {5, 0}, 1);
  EXPECT_FALSE(alignPatch(reference, at, moved, at, same, 2)) << "further than allowed";
}

}  // namespace
}  // namespace cf
