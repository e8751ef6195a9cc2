// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "disparity_filter.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace cf {
namespace {

constexpr int kWindow = 7;  // px, of the correlation
constexpr float kCorrelationNone = 0.2F, kCorrelationFull = 0.9F;
constexpr float kTextureSigma = 2.5F;  // grey levels: noise of a photo

constexpr float kMinSlopeEnergy = 4;  // squared grey levels per px
constexpr float kMaxRefinementPx = 0.75F;
constexpr int kFillStep = 32;  // 1/16 px of the coarse level
constexpr float kFillConfidence = 0.5F;

cv::Mat boxMean(const cv::Mat& image) {
  cv::Mat mean;
  cv::boxFilter(image, mean, CV_32F, {kWindow, kWindow}, {-1, -1}, true,
                cv::BORDER_CONSTANT | cv::BORDER_ISOLATED);
  return mean;
}

}  // namespace

void clearOutside(cv::Mat& disparity, const StereoInput& input) {
  for (int v = 0; v < disparity.rows; ++v) {
    auto* d = disparity.ptr<std::int16_t>(v);
    const auto* inside = input.reference_inside.ptr<uchar>(v);
    const auto* partner = input.partner_inside.ptr<uchar>(v);
    for (int u = 0; u < disparity.cols; ++u) {
      if (d[u] == kNoDisparity) continue;
      const int x = u - static_cast<int>(std::floor(d[u] / 16.0 + 0.5));
      if (!inside[u] || x < 0 || x >= input.partner.cols || !partner[x]) d[u] = kNoDisparity;
    }
  }
}

void clearSpeckles(cv::Mat& disparity, int min_pixels, double max_step_px) {
  cv::filterSpeckles(disparity, kNoDisparity, min_pixels, 16 * max_step_px);
}

void refineDisparity(cv::Mat& disparity, const StereoInput& input) {
  const cv::Size size = disparity.size();
  const auto zero = [&size] { return cv::Mat(size, CV_32F, cv::Scalar(0)); };
  cv::Mat slope = zero(), rest = zero(), slope2 = zero(), product = zero(), valid = zero();
  for (int v = 0; v < size.height; ++v) {
    const auto* d = disparity.ptr<std::int16_t>(v);
    const auto* left = input.reference.ptr<uchar>(v);
    const auto* right = input.partner.ptr<uchar>(v);
    for (int u = 0; u < size.width; ++u) {
      if (d[u] == kNoDisparity) continue;
      const int position = 16 * u - d[u], x = position >> 4;
      if (x < 1 || x + 2 >= input.partner.cols) continue;
      const float t = static_cast<float>(position & 15) / 16.F;
      const auto between = [t](int a, int b) {
        return static_cast<float>(a) + t * static_cast<float>(b - a);
      };
      const float g = between(right[x + 1] - right[x - 1], right[x + 2] - right[x]) / 2;
      const float e = static_cast<float>(left[u]) - between(right[x], right[x + 1]);
      slope.ptr<float>(v)[u] = g;
      rest.ptr<float>(v)[u] = e;
      slope2.ptr<float>(v)[u] = g * g;
      product.ptr<float>(v)[u] = g * e;
      valid.ptr<float>(v)[u] = 1;
    }
  }
  for (cv::Mat* sum : {&slope, &rest, &slope2, &product, &valid}) *sum = boxMean(*sum);
  for (int v = 0; v < size.height; ++v) {
    auto* d = disparity.ptr<std::int16_t>(v);
    for (int u = 0; u < size.width; ++u) {
      if (d[u] == kNoDisparity) continue;
      const float n = std::max(valid.ptr<float>(v)[u], 0.01F);
      const float mean = slope.ptr<float>(v)[u] / n;
      const float energy = slope2.ptr<float>(v)[u] / n - mean * mean;
      if (energy < kMinSlopeEnergy) continue;
      const float shift =
          (product.ptr<float>(v)[u] / n - mean * rest.ptr<float>(v)[u] / n) / energy;
      if (std::abs(shift) > kMaxRefinementPx) continue;
      d[u] = static_cast<std::int16_t>(d[u] - std::lround(16 * shift));
    }
  }
}

void smoothDisparity(cv::Mat& disparity, double max_step_px) {
  const cv::Mat in = disparity.clone();
  const int step = static_cast<int>(16 * max_step_px);
  for (int v = 1; v + 1 < in.rows; ++v) {
    const std::int16_t* rows[] = {in.ptr<std::int16_t>(v - 1), in.ptr<std::int16_t>(v),
                                  in.ptr<std::int16_t>(v + 1)};
    auto* out = disparity.ptr<std::int16_t>(v);
    for (int u = 1; u + 1 < in.cols; ++u) {
      const int centre = rows[1][u];
      if (centre == kNoDisparity) continue;
      int sum = 4 * centre, weight = 4;
      for (int j = 0; j < 3; ++j) {
        for (int i = -1; i <= 1; ++i) {
          if (j == 1 && i == 0) continue;
          const int d = rows[j][u + i];
          if (std::abs(d - centre) > step) continue;  // kNoDisparity is far from everything
          const int w = j == 1 || i == 0 ? 2 : 1;
          sum += w * d;
          weight += w;
        }
      }
      out[u] = static_cast<std::int16_t>(std::lround(static_cast<double>(sum) / weight));
    }
  }
}

void fillFromCoarse(StereoOutput& fine, const StereoOutput& coarse) {
  // A smooth place of the coarse level: the 3 x 3 neighbours all known and within a step.
  cv::Mat least, greatest;
  const cv::Mat square = cv::Mat::ones(3, 3, CV_8U);
  cv::erode(coarse.disparity, least, square, {-1, -1}, 1, cv::BORDER_REPLICATE);
  cv::dilate(coarse.disparity, greatest, square, {-1, -1}, 1, cv::BORDER_REPLICATE);
  for (int v = 0; v < fine.disparity.rows; ++v) {
    auto* d = fine.disparity.ptr<std::int16_t>(v);
    auto* confidence = fine.confidence.ptr<uchar>(v);
    const int y = std::min(v / 2, coarse.disparity.rows - 1);
    const auto* low = least.ptr<std::int16_t>(y);
    const auto* high = greatest.ptr<std::int16_t>(y);
    const auto* from = coarse.disparity.ptr<std::int16_t>(y);
    const auto* from_confidence = coarse.confidence.ptr<uchar>(y);
    for (int u = 0; u < fine.disparity.cols; ++u) {
      const int x = std::min(u / 2, coarse.disparity.cols - 1);
      if (confidence[u] != 0 || low[x] == kNoDisparity || high[x] - low[x] > kFillStep) continue;
      const int beside = u % 2 && x + 1 < coarse.disparity.cols ? from[x + 1] : from[x];
      d[u] = static_cast<std::int16_t>(from[x] + beside);
      confidence[u] = static_cast<uchar>(kFillConfidence * from_confidence[x]);
      if (confidence[u] == 0) d[u] = kNoDisparity;
    }
  }
}

cv::Mat confidenceOf(const cv::Mat& disparity, const StereoInput& input) {
  const cv::Size size = disparity.size();
  cv::Mat a(size, CV_32F, cv::Scalar(0)), b(size, CV_32F, cv::Scalar(0));
  cv::Mat ab(size, CV_32F, cv::Scalar(0)), aa(size, CV_32F, cv::Scalar(0)),
      bb(size, CV_32F, cv::Scalar(0)), valid(size, CV_32F, cv::Scalar(0));
  for (int v = 0; v < size.height; ++v) {
    const auto* d = disparity.ptr<std::int16_t>(v);
    const auto* left = input.reference.ptr<uchar>(v);
    const auto* right = input.partner.ptr<uchar>(v);
    for (int u = 0; u < size.width; ++u) {
      if (d[u] == kNoDisparity) continue;
      const int position = 16 * u - d[u];
      const int x = position >> 4;
      if (x < 0 || x + 1 >= input.partner.cols) continue;
      const float t = static_cast<float>(position & 15) / 16.F;
      // Grey about its middle, so that float sums of squares stay exact enough.
      const float l = static_cast<float>(left[u]) - 128.F;
      const float r =
          static_cast<float>(right[x]) * (1 - t) + static_cast<float>(right[x + 1]) * t - 128.F;
      a.ptr<float>(v)[u] = l;
      b.ptr<float>(v)[u] = r;
      aa.ptr<float>(v)[u] = l * l;
      bb.ptr<float>(v)[u] = r * r;
      ab.ptr<float>(v)[u] = l * r;
      valid.ptr<float>(v)[u] = 1;
    }
  }
  a = boxMean(a);
  b = boxMean(b);
  aa = boxMean(aa);
  bb = boxMean(bb);
  ab = boxMean(ab);
  valid = boxMean(valid);
  cv::Mat confidence(size, CV_8U, cv::Scalar(0));
  for (int v = 0; v < size.height; ++v) {
    const auto* d = disparity.ptr<std::int16_t>(v);
    for (int u = 0; u < size.width; ++u) {
      if (d[u] == kNoDisparity) continue;
      const float n = std::max(valid.ptr<float>(v)[u], 0.01F);
      const float ma = a.ptr<float>(v)[u] / n, mb = b.ptr<float>(v)[u] / n;
      const float va = aa.ptr<float>(v)[u] / n - ma * ma, vb = bb.ptr<float>(v)[u] / n - mb * mb;
      const float noise = kTextureSigma * kTextureSigma;
      const float correlation =
          (ab.ptr<float>(v)[u] / n - ma * mb) / std::sqrt(std::max(va, 0.1F) * std::max(vb, 0.1F));
      const float alike = std::clamp(
          (correlation - kCorrelationNone) / (kCorrelationFull - kCorrelationNone), 0.F, 1.F);
      const float texture = std::max(va, 0.F) / (std::max(va, 0.F) + noise);
      confidence.ptr<uchar>(v)[u] = static_cast<uchar>(
          std::lround(255.F * alike * std::sqrt(texture) * std::min(1.F, 2 * n)));
    }
  }
  return confidence;
}

}  // namespace cf
