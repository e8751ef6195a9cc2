// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "disparity_filter.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "lanes.h"

namespace cf {
namespace {

constexpr int kHidden = 24;    // 1/16 px, by which a nearer match hides another
constexpr int kBeside = 1;     // px of the partner that a match covers on both sides
constexpr int kFillStep = 32;  // 1/16 px of the coarse level
constexpr float kFillConfidence = 0.5F;

CF_CLONES void smoothRow(const Cost* const* rows, int width, Cost step, Cost* out) {
  for (int u = 1; u + 1 < width; ++u) {
    const Cost centre = rows[1][u];
    Cost sum = 0, weight = 4;  // of differences from the centre
    for (int j = 0; j < 3; ++j) {
      for (int i = -1; i <= 1; ++i) {
        if (j == 1 && i == 0) continue;
        // Great where there is none, even if it does not fit its type.
        const auto difference = static_cast<Cost>(rows[j][u + i] - centre);
        const auto w = static_cast<Cost>(j == 1 || i == 0 ? 2 : 1);
        const bool near = difference <= step && difference >= -step;
        sum = static_cast<Cost>(sum + (near ? w * difference : 0));
        weight = static_cast<Cost>(weight + (near ? w : 0));
      }
    }
    const float mean = static_cast<float>(sum) / static_cast<float>(weight);
    const int rounded = static_cast<int>(mean + 64.5F) - 64;
    out[u] = static_cast<std::int16_t>(centre + (centre == kNoDisparity ? 0 : rounded));
  }
}

/// Fills short gaps of a row or column whose ends agree.
void fillLine(std::int16_t* line, int n, std::ptrdiff_t stride, int max_gap, int max_step) {
  int last = -1;  // that is known
  for (int k = 0; k < n; ++k) {
    const int d = line[k * stride];
    if (d == kNoDisparity) continue;
    const int gap = k - last - 1;
    if (last >= 0 && gap > 0 && gap <= max_gap) {
      const int from = line[last * stride];
      for (int i = last + 1; i < k && std::abs(d - from) <= max_step; ++i) {
        line[i * stride] = static_cast<std::int16_t>(from + (d - from) * (i - last) / (k - last));
      }
    }
    last = k;
  }
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

void fillGaps(cv::Mat& disparity, int max_gap_px, double max_step_px) {
  const int step = static_cast<int>(16 * max_step_px);
  const auto rows = static_cast<std::ptrdiff_t>(disparity.step1());
  for (int v = 0; v < disparity.rows; ++v) {
    fillLine(disparity.ptr<std::int16_t>(v), disparity.cols, 1, max_gap_px, step);
  }
  for (int u = 0; u < disparity.cols; ++u) {
    fillLine(disparity.ptr<std::int16_t>(0) + u, disparity.rows, rows, max_gap_px, step);
  }
}

void clearSpeckles(cv::Mat& disparity, int min_pixels, double max_step_px) {
  cv::filterSpeckles(disparity, kNoDisparity, min_pixels, 16 * max_step_px);
}

void smoothDisparity(cv::Mat& disparity, double max_step_px) {
  const cv::Mat in = disparity.clone();
  const auto step = static_cast<Cost>(16 * max_step_px);
  for (int v = 1; v + 1 < in.rows; ++v) {
    const std::int16_t* rows[] = {in.ptr<std::int16_t>(v - 1), in.ptr<std::int16_t>(v),
                                  in.ptr<std::int16_t>(v + 1)};
    smoothRow(rows, in.cols, step, disparity.ptr<std::int16_t>(v));
  }
}

void fillFromCoarse(StereoOutput& fine, const StereoOutput& coarse, int partner_width) {
  // The greatest disparity that lands on each pixel of the partner: what hides others.
  std::vector<std::int16_t> nearest(static_cast<std::size_t>(partner_width));
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
    std::fill(nearest.begin(), nearest.end(), kNoDisparity);
    for (int u = 0; u < fine.disparity.cols; ++u) {
      if (confidence[u] == 0) continue;
      const int at = u - ((d[u] + 8) >> 4);
      for (int k = std::max(0, at - kBeside); k <= std::min(partner_width - 1, at + kBeside); ++k) {
        auto& there = nearest[static_cast<std::size_t>(k)];
        there = std::max(there, d[u]);
      }
    }
    for (int u = 0; u < fine.disparity.cols; ++u) {
      const int x = std::min(u / 2, coarse.disparity.cols - 1);
      if (confidence[u] != 0 || low[x] == kNoDisparity || high[x] - low[x] > kFillStep) continue;
      const int beside = u % 2 && x + 1 < coarse.disparity.cols ? from[x + 1] : from[x];
      const int filled = from[x] + beside, at = u - ((filled + 8) >> 4);
      if (at < 0 || at >= partner_width) continue;
      if (nearest[static_cast<std::size_t>(at)] > filled + kHidden) continue;
      d[u] = static_cast<std::int16_t>(filled);
      confidence[u] = static_cast<uchar>(kFillConfidence * from_confidence[x]);
      if (confidence[u] == 0) d[u] = kNoDisparity;
    }
  }
}

}  // namespace cf
