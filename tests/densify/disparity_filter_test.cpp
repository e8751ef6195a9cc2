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

TEST(ClearSpeckles, clearsSmallPatchesOnly) {
  // A ring of 16 px about an islet of 4, and a ramp whose steps join it to one patch.
  cv::Mat d(12, 20, CV_16S, cv::Scalar(kNone));
  cv::rectangle(d, cv::Rect(1, 1, 5, 5), cv::Scalar(160), 1);
  d(cv::Rect(3, 3, 1, 1)) = 640;
  for (int u = 8; u < 20; ++u) d.col(u) = 16 * u;
  d(cv::Rect(8, 6, 12, 1)) = kNone;
  cv::Mat all = d.clone();
  clearSpeckles(all, 17, 1.5);
  EXPECT_EQ(all.at<std::int16_t>(1, 1), kNone);
  EXPECT_EQ(all.at<std::int16_t>(3, 3), kNone);
  EXPECT_EQ(all.at<std::int16_t>(0, 12), 16 * 12);
  EXPECT_EQ(all.at<std::int16_t>(11, 19), 16 * 19);
  cv::Mat most = d.clone();
  clearSpeckles(most, 16, 1.5);
  EXPECT_EQ(most.at<std::int16_t>(1, 1), 160);
  EXPECT_EQ(most.at<std::int16_t>(3, 3), kNone);
  cv::Mat none = d.clone();
  clearSpeckles(none, 73, 1.5);
  EXPECT_EQ(cv::countNonZero(none != kNone), 0);
}

TEST(SmoothDisparity, averagesWithinAStepOnly) {
  cv::Mat d(9, 37, CV_16S, cv::Scalar(160));
  d.colRange(20, 37) = 480;
  d.at<std::int16_t>(4, 8) = 168;
  d.at<std::int16_t>(4, 30) = kNone;
  smoothDisparity(d, 1);
  EXPECT_EQ(d.at<std::int16_t>(4, 8), 162);   // a quarter of the weight is its own
  EXPECT_EQ(d.at<std::int16_t>(4, 9), 161);   // 2 of 16
  EXPECT_EQ(d.at<std::int16_t>(4, 19), 160);  // beside the step
  EXPECT_EQ(d.at<std::int16_t>(4, 20), 480);
  EXPECT_EQ(d.at<std::int16_t>(4, 30), kNone);
  EXPECT_EQ(d.at<std::int16_t>(0, 36), 480);
}

TEST(FillByVote, fillsRoughSurfacesAndNoOtherHoles) {
  // On the left a rough surface about 320 of which the speckle filter has left nothing; in the
  // middle a clean surface with a hole; on the right disparities all over the range.
  cv::Mat raw(32, 96, CV_16S, cv::Scalar(kNone));
  cv::RNG random(2);
  for (int v = 0; v < raw.rows; ++v) {
    for (int u = 0; u < raw.cols; ++u) {
      auto& d = raw.at<std::int16_t>(v, u);
      if (u < 32) {
        if (random.uniform(0, 2)) d = static_cast<std::int16_t>(320 + random.uniform(-20, 21));
      } else if (u < 64) {
        d = 160;
      } else {
        d = static_cast<std::int16_t>(random.uniform(0, 1600));
      }
    }
  }
  raw(cv::Rect(44, 12, 8, 8)) = kNone;
  cv::Mat d = raw.clone();
  d.colRange(0, 32) = kNone;
  d.colRange(64, 96) = kNone;
  fillByVote(d, raw);
  for (int v = 0; v < d.rows; ++v) {
    for (int u = 0; u < 24; ++u) EXPECT_NEAR(d.at<std::int16_t>(v, u), 320, 12) << u << " " << v;
    for (int u = 72; u < 96; ++u) EXPECT_EQ(d.at<std::int16_t>(v, u), kNone) << u << " " << v;
  }
  EXPECT_EQ(cv::countNonZero(d(cv::Rect(44, 12, 8, 8)) != kNone), 0);
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
