// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "compose.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace cf {
namespace {

constexpr double kDarkest = 0.4;         // share of the light that a deep step takes away
constexpr double kHiddenOpacity = 0.45;  // of a line behind the surface
constexpr double kRimLight = 0.45;

/// An empty pixel and what its neighbours would make of it.
struct Gap {
  cv::Point at;
  float depth_m = 0;
  cv::Vec3b colour;
};

/// The pixel from its neighbours, if enough of them are there.
bool fills(const Layer& layer, cv::Point at, Gap& gap) {
  constexpr int kSurrounded = 5;  // of 8 neighbours
  int count = 0;
  float depth = 0;
  cv::Vec3i sum(0, 0, 0);
  for (int dy = -1; dy <= 1; ++dy) {
    const auto* depths = layer.depth.ptr<float>(at.y + dy) + at.x;
    const auto* colours = layer.colour.ptr<cv::Vec3b>(at.y + dy) + at.x;
    for (int dx = -1; dx <= 1; ++dx) {
      if (depths[dx] <= 0) continue;
      ++count;
      depth += depths[dx];
      sum += cv::Vec3i(colours[dx]);
    }
  }
  if (count < kSurrounded) return false;
  gap = {at, depth / static_cast<float>(count), cv::Vec3b(sum / count)};
  return true;
}

}  // namespace

void closeGaps(Layer& layer, int rounds) {
  std::vector<Gap> gaps;
  Gap gap;
  for (int y = 1; y + 1 < layer.depth.rows; ++y) {
    const auto* depth = layer.depth.ptr<float>(y);
    const auto* above = layer.depth.ptr<float>(y - 1);
    const auto* below = layer.depth.ptr<float>(y + 1);
    for (int x = 1; x + 1 < layer.depth.cols; ++x) {
      if (depth[x] > 0) continue;
      // Five of eight neighbours: one of these four at least.
      if (depth[x - 1] <= 0 && depth[x + 1] <= 0 && above[x] <= 0 && below[x] <= 0) continue;
      if (fills(layer, {x, y}, gap)) gaps.push_back(gap);
    }
  }
  for (int round = 0; round < rounds && !gaps.empty(); ++round) {
    for (const Gap& g : gaps) {
      layer.depth.at<float>(g.at) = g.depth_m;
      layer.colour.at<cv::Vec3b>(g.at) = g.colour;
    }
    // Only beside these can there be more.
    std::vector<cv::Point> beside;
    for (const Gap& g : gaps)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          const cv::Point p(g.at.x + dx, g.at.y + dy);
          if (p.x > 0 && p.y > 0 && p.x + 1 < layer.depth.cols && p.y + 1 < layer.depth.rows &&
              layer.depth.at<float>(p) <= 0)
            beside.push_back(p);
        }
    const auto rowMajor = [](cv::Point a, cv::Point b) {
      return a.y != b.y ? a.y < b.y : a.x < b.x;
    };
    std::sort(beside.begin(), beside.end(), rowMajor);
    beside.erase(std::unique(beside.begin(), beside.end()), beside.end());
    gaps.clear();
    for (const cv::Point p : beside)
      if (fills(layer, p, gap)) gaps.push_back(gap);
  }
}

void shadeRelief(Layer& layer, const ViewCamera& camera, double reach_px, double ignore_px,
                 int step) {
  // Mean depth of the surroundings, of pixels that have one.
  cv::Mat depth, has_depth;
  cv::resize(layer.depth, depth, {layer.depth.cols / step, layer.depth.rows / step}, 0, 0,
             cv::INTER_NEAREST);
  cv::Mat(depth > 0).convertTo(has_depth, CV_32F, 1 / 255.0);
  cv::Mat around, weight;
  const int width = 2 * static_cast<int>(std::lround(reach_px / step)) + 1;
  cv::blur(depth, around, {width, width}, {-1, -1}, cv::BORDER_CONSTANT);
  cv::blur(around, around, {width, width}, {-1, -1}, cv::BORDER_CONSTANT);
  cv::blur(has_depth, weight, {width, width}, {-1, -1}, cv::BORDER_CONSTANT);
  cv::blur(weight, weight, {width, width}, {-1, -1}, cv::BORDER_CONSTANT);
  for (int y = 0; y < depth.rows; ++y) {
    const auto* here = depth.ptr<float>(y);
    const auto* mean = around.ptr<float>(y);
    const auto* known = weight.ptr<float>(y);
    for (int x = 0; x < depth.cols; ++x) {
      const double d = static_cast<double>(here[x]), w = static_cast<double>(known[x]);
      if (d <= 0 || w <= 0) continue;
      const double behind_m = d - static_cast<double>(mean[x]) / w;
      const double behind_px = behind_m / camera.metresPerPixel(d) - ignore_px;
      if (behind_px <= 0) continue;
      const double light = 1 - kDarkest * (1 - std::exp(-behind_px / reach_px));
      for (int j = 0; j < step; ++j) {
        auto* colours = layer.colour.ptr<cv::Vec3b>(step * y + j) + step * x;
        const auto* depths = layer.depth.ptr<float>(step * y + j) + step * x;
        for (int i = 0; i < step; ++i) {
          if (depths[i] <= 0) continue;
          for (int k = 0; k < 3; ++k)
            colours[i][k] = cv::saturate_cast<std::uint8_t>(light * colours[i][k]);
        }
      }
    }
  }
}

void layOver(Layer& surface, const Layer& lines, int rim_px) {
  const cv::Mat mask = lines.depth > 0;
  cv::Mat rim;
  cv::dilate(mask, rim,
             cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * rim_px + 1, 2 * rim_px + 1}));
  for (int y = 0; y < mask.rows; ++y) {
    const auto* near_line = rim.ptr<std::uint8_t>(y);
    const auto* on_line = mask.ptr<std::uint8_t>(y);
    for (int x = 0; x < mask.cols; ++x) {
      if (near_line[x] == 0) continue;
      auto& colour = surface.colour.at<cv::Vec3b>(y, x);
      if (on_line[x] == 0) {
        for (int k = 0; k < 3; ++k) colour[k] = static_cast<std::uint8_t>(kRimLight * colour[k]);
        continue;
      }
      const float under = surface.depth.at<float>(y, x), over = lines.depth.at<float>(y, x);
      const double opacity = under <= 0 || over <= under ? 1.0 : kHiddenOpacity;
      const cv::Vec3b line = lines.colour.at<cv::Vec3b>(y, x);
      for (int k = 0; k < 3; ++k)
        colour[k] = cv::saturate_cast<std::uint8_t>(opacity * line[k] + (1 - opacity) * colour[k]);
    }
  }
}

}  // namespace cf
