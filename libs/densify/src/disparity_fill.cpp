// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "disparity_filter.h"
#include "lanes.h"

namespace cf {
namespace {

constexpr int kHidden = 24;    // 1/16 px, by which a nearer match hides another
constexpr int kBeside = 1;     // px of the partner that a match covers on both sides
constexpr int kFillStep = 64;  // 1/16 px of the coarse level
constexpr float kFillConfidence = 0.7F;
constexpr int kWeak = 24;  // a match of less confidence yields to that of the coarse level

constexpr int kCell = 4;           // px, side of a cell of the vote
constexpr int kVoters = 4;         // px around the cell that vote, too
constexpr double kKnown = 0.3;     // least share of the voters that is known ...
constexpr double kSpeckles = 0.2;  // ... and was cleared as speckles
constexpr double kAgree = 0.5;     // least share of the known ones close to their median
constexpr int kClose = 24;         // 1/16 px
constexpr int kBlend = 64;         // 1/16 px, between cells that belong together

cv::Rect within(const cv::Mat& image, int left, int top, int side) {
  return cv::Rect(left, top, side, side) & cv::Rect({}, image.size());
}

bool allKnown(const cv::Mat& disparity, const cv::Rect& area) {
  for (int v = area.y; v < area.y + area.height; ++v) {
    const auto* d = disparity.ptr<std::int16_t>(v) + area.x;
    if (std::find(d, d + area.width, kNoDisparity) != d + area.width) return false;
  }
  return true;
}

/// The disparity of the surface about a cell, or kNoDisparity. `votes` is scratch.
int voteOf(const cv::Mat& disparity, const cv::Mat& raw, int left, int top,
           std::vector<std::int16_t>& votes) {
  const cv::Rect cell = within(raw, left, top, kCell);
  if (allKnown(disparity, cell)) {
    return disparity.at<std::int16_t>(cell.y + cell.height / 2, cell.x + cell.width / 2);
  }
  const cv::Rect area = within(raw, left - kVoters, top - kVoters, kCell + 2 * kVoters);
  votes.clear();
  int speckles = 0;
  for (int v = area.y; v < area.y + area.height; ++v) {
    const auto* before = raw.ptr<std::int16_t>(v);
    const auto* after = disparity.ptr<std::int16_t>(v);
    for (int u = area.x; u < area.x + area.width; ++u) {
      if (before[u] == kNoDisparity) continue;
      votes.push_back(before[u]);
      speckles += after[u] == kNoDisparity;
    }
  }
  const auto known = static_cast<double>(votes.size());
  if (known < kKnown * area.area() || speckles < kSpeckles * area.area()) return kNoDisparity;
  const auto middle = votes.begin() + static_cast<std::ptrdiff_t>(votes.size() / 2);
  std::nth_element(votes.begin(), middle, votes.end());
  const int median = *middle;
  const auto close = std::count_if(votes.begin(), votes.end(),
                                   [&](int d) { return std::abs(d - median) <= kClose; });
  return static_cast<double>(close) < kAgree * known ? kNoDisparity : median;
}

/// The surface at a pixel of a cell, linear between the cells that belong to it.
int surfaceAt(const cv::Mat& surface, int own, int u, int v) {
  // In half pixels, from the centre of the cell on the upper left.
  const int x = 2 * u + 1 + kCell, y = 2 * v + 1 + kCell;
  const int i = x / (2 * kCell) - 1, j = y / (2 * kCell) - 1;
  const int s = x % (2 * kCell), t = y % (2 * kCell);
  int sum = 0, weight = 0;
  for (int b = 0; b < 2; ++b) {
    for (int a = 0; a < 2; ++a) {
      const int there = surface.at<std::int16_t>(std::clamp(j + b, 0, surface.rows - 1),
                                                 std::clamp(i + a, 0, surface.cols - 1));
      if (there == kNoDisparity || std::abs(there - own) > kBlend) continue;
      const int w = (a ? s : 2 * kCell - s) * (b ? t : 2 * kCell - t);
      sum += w * (there - own);
      weight += w;
    }
  }
  return own + sum / std::max(1, weight);
}

/// `from` holds one more at both ends.
CF_CLONES void greatestBeside(const std::int16_t* from, int n, std::int16_t* to) {
  static_assert(kBeside == 1);
  for (int k = 0; k < n; ++k) to[k] = std::max(std::max(from[k], from[k + 1]), from[k + 2]);
}

}  // namespace

void fillByVote(cv::Mat& disparity, const cv::Mat& raw) {
  cv::Mat surface((raw.rows + kCell - 1) / kCell, (raw.cols + kCell - 1) / kCell, CV_16S);
  std::vector<std::int16_t> votes;
  for (int j = 0; j < surface.rows; ++j) {
    for (int i = 0; i < surface.cols; ++i) {
      surface.at<std::int16_t>(j, i) =
          static_cast<std::int16_t>(voteOf(disparity, raw, i * kCell, j * kCell, votes));
    }
  }
  for (int v = 0; v < raw.rows; ++v) {
    auto* d = disparity.ptr<std::int16_t>(v);
    const auto* row = surface.ptr<std::int16_t>(v / kCell);
    for (int u = 0; u < raw.cols; ++u) {
      const int own = row[u / kCell];
      if (d[u] != kNoDisparity || own == kNoDisparity) continue;
      d[u] = static_cast<std::int16_t>(surfaceAt(surface, own, u, v));
    }
  }
}

void fillFromCoarse(StereoOutput& fine, const StereoOutput& coarse, int partner_width) {
  // The greatest disparity that lands on each pixel of the partner: what hides others.
  std::vector<std::int16_t> nearest(static_cast<std::size_t>(partner_width));
  std::vector<std::int16_t> landed(nearest.size() + 2 * kBeside);
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
    std::fill(landed.begin(), landed.end(), kNoDisparity);
    for (int u = 0; u < fine.disparity.cols; ++u) {
      const int at = u - ((d[u] + 8) >> 4) + kBeside;
      if (confidence[u] == 0 || at < 0 || at >= partner_width + 2 * kBeside) continue;
      auto& there = landed[static_cast<std::size_t>(at)];
      there = std::max(there, d[u]);
    }
    greatestBeside(landed.data(), partner_width, nearest.data());
    for (int u = 0; u < fine.disparity.cols; ++u) {
      const int x = std::min(u / 2, coarse.disparity.cols - 1);
      if (confidence[u] >= kWeak || low[x] == kNoDisparity || high[x] - low[x] > kFillStep)
        continue;
      const auto confidence_here = static_cast<uchar>(kFillConfidence * from_confidence[x]);
      if (confidence_here <= confidence[u]) continue;
      const int beside = u % 2 && x + 1 < coarse.disparity.cols ? from[x + 1] : from[x];
      const int filled = from[x] + beside, at = u - ((filled + 8) >> 4);
      if (at < 0 || at >= partner_width) continue;
      if (nearest[static_cast<std::size_t>(at)] > filled + kHidden) continue;
      d[u] = static_cast<std::int16_t>(filled);
      confidence[u] = confidence_here;
    }
  }
}

}  // namespace cf
