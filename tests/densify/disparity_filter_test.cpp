// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "disparity_filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace cf {
namespace {

constexpr std::int16_t kNone = kNoDisparity;

cv::Mat row(std::initializer_list<int> values) {
  cv::Mat out(1, static_cast<int>(values.size()), CV_16S);
  int u = 0;
  for (const int v : values) out.at<std::int16_t>(0, u++) = static_cast<std::int16_t>(v);
  return out;
}

/// Blurred noise, and the same shifted by a disparity [1/16 px] that differs by halves of the
/// image.
StereoInput shiftedNoise(int left_16, int right_16) {
  constexpr int kWidth = 160, kHeight = 60, kFine = 16;
  cv::Mat fine(kHeight, kWidth * kFine, CV_8U);
  cv::RNG random(1);
  random.fill(fine, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(fine, fine, {}, 1.5 * kFine, 1.2);
  cv::normalize(fine, fine, 0, 255, cv::NORM_MINMAX);
  StereoInput input;
  input.reference.create(kHeight, kWidth, CV_8U);
  input.partner.create(kHeight, kWidth, CV_8U);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const int d = u < kWidth / 2 ? left_16 : right_16;
      input.reference.at<uchar>(v, u) = fine.at<uchar>(v, kFine * u);
      input.partner.at<uchar>(v, u) =
          fine.at<uchar>(v, std::clamp(kFine * u + d, 0, fine.cols - 1));
    }
  }
  input.reference_inside = input.partner_inside = cv::Mat(kHeight, kWidth, CV_8U, cv::Scalar(255));
  return input;
}

TEST(FillGaps, fillsShortGapsWhoseEndsAgree) {
  cv::Mat d = row({160, kNone, kNone, 172, kNone, 200, kNone, kNone, kNone, kNone, 200, kNone});
  fillGaps(d, 3, 1);
  EXPECT_EQ(
      cv::norm(d, row({160, 164, 168, 172, kNone, 200, kNone, kNone, kNone, kNone, 200, kNone}),
               cv::NORM_INF),
      0);
  cv::Mat column = row({160, kNone, 160}).t();
  fillGaps(column, 3, 1);
  EXPECT_EQ(column.at<std::int16_t>(1, 0), 160);
}

TEST(FillFromCoarse, leavesWhatSomethingNearerHides) {
  // Disparity 8 px on the right; left of it the background of 0 px, of which it hides 8 px.
  constexpr int kWidth = 64, kHeight = 8;
  StereoOutput fine{cv::Mat(kHeight, kWidth, CV_16S, cv::Scalar(kNone)),
                    cv::Mat(kHeight, kWidth, CV_8U, cv::Scalar(0))};
  fine.disparity.colRange(32, kWidth) = 16 * 8;
  fine.confidence.colRange(32, kWidth) = 200;
  const StereoOutput coarse{cv::Mat(kHeight / 2, kWidth / 2, CV_16S, cv::Scalar(0)),
                            cv::Mat(kHeight / 2, kWidth / 2, CV_8U, cv::Scalar(200))};
  fillFromCoarse(fine, coarse, kWidth);
  const auto* d = fine.disparity.ptr<std::int16_t>(4);
  EXPECT_EQ(d[10], 0);
  EXPECT_EQ(d[22], 0);
  for (int u = 24; u < 32; ++u) EXPECT_EQ(d[u], kNone) << u;
  EXPECT_EQ(d[32], 16 * 8);
  EXPECT_GT(fine.confidence.at<uchar>(4, 10), 0);
  EXPECT_LT(fine.confidence.at<uchar>(4, 10), 200);
}

TEST(RefineDisparity, findsTheRestOfAPixel) {
  for (const int true_16 : {0, 3, 8, 13}) {
    const StereoInput input = shiftedNoise(true_16, true_16);
    cv::Mat d(input.reference.size(), CV_16S, cv::Scalar(true_16 < 8 ? 0 : 16));
    refineDisparity(d, input);
    EXPECT_NEAR(cv::mean(d(cv::Rect(20, 10, 120, 40)))[0], true_16, 1.5);
  }
}

TEST(ConfidenceOf, fallsWithWrongDisparitiesAndBesideSteps) {
  const StereoInput input = shiftedNoise(0, 0);
  const cv::Rect inner(20, 10, 120, 40);
  const cv::Mat right(input.reference.size(), CV_16S, cv::Scalar(0));
  const double sure = cv::mean(confidenceOf(right, input)(inner))[0];
  EXPECT_GT(sure, 200);
  const cv::Mat wrong(input.reference.size(), CV_16S, cv::Scalar(16 * 9));
  EXPECT_LT(cv::mean(confidenceOf(wrong, input)(inner))[0], 0.3 * sure);
  cv::Mat stepped = right.clone();
  stepped.colRange(80, 83) = 16 * 9;
  EXPECT_LT(confidenceOf(stepped, input).at<uchar>(30, 79), 0.5 * sure);
  cv::Mat holed = right.clone();
  holed.colRange(80, 83) = kNone;
  const cv::Mat confidence = confidenceOf(holed, input);
  EXPECT_EQ(confidence.at<uchar>(30, 81), 0);
  EXPECT_GT(confidence.at<uchar>(30, 79), 150);
}

}  // namespace
}  // namespace cf
