// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "compose.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace cf {
namespace {

constexpr double kDarkest = 0.55;        // share of the light that a deep step takes away
constexpr double kHiddenOpacity = 0.45;  // of a line behind the surface
constexpr double kRimLight = 0.45;

}  // namespace

void closeGaps(Layer& layer, int rounds) {
  constexpr int kSurrounded = 5;  // of 8 neighbours
  for (int round = 0; round < rounds; ++round) {
    const Layer before{layer.colour.clone(), layer.depth.clone()};
    for (int y = 1; y + 1 < layer.depth.rows; ++y)
      for (int x = 1; x + 1 < layer.depth.cols; ++x) {
        if (before.depth.at<float>(y, x) > 0) continue;
        int count = 0;
        float depth = 0;
        cv::Vec3i sum(0, 0, 0);
        for (int dy = -1; dy <= 1; ++dy)
          for (int dx = -1; dx <= 1; ++dx) {
            const float d = before.depth.at<float>(y + dy, x + dx);
            if (d <= 0) continue;
            ++count;
            depth += d;
            sum += cv::Vec3i(before.colour.at<cv::Vec3b>(y + dy, x + dx));
          }
        if (count < kSurrounded) continue;
        layer.depth.at<float>(y, x) = depth / static_cast<float>(count);
        layer.colour.at<cv::Vec3b>(y, x) = cv::Vec3b(sum / count);
      }
  }
}

void shadeRelief(Layer& layer, const ViewCamera& camera, double reach_px, double ignore_px) {
  // Mean depth of the surroundings, of pixels that have one.
  cv::Mat has_depth;
  cv::Mat(layer.depth > 0).convertTo(has_depth, CV_32F, 1 / 255.0);
  cv::Mat around, weight;
  const int width = 2 * static_cast<int>(std::lround(reach_px)) + 1;
  cv::blur(layer.depth, around, {width, width}, {-1, -1}, cv::BORDER_CONSTANT);
  cv::blur(around, around, {width, width}, {-1, -1}, cv::BORDER_CONSTANT);
  cv::blur(has_depth, weight, {width, width}, {-1, -1}, cv::BORDER_CONSTANT);
  cv::blur(weight, weight, {width, width}, {-1, -1}, cv::BORDER_CONSTANT);
  for (int y = 0; y < layer.depth.rows; ++y)
    for (int x = 0; x < layer.depth.cols; ++x) {
      const double d = static_cast<double>(layer.depth.at<float>(y, x));
      const double w = static_cast<double>(weight.at<float>(y, x));
      if (d <= 0 || w <= 0) continue;
      const double behind_m = d - static_cast<double>(around.at<float>(y, x)) / w;
      const double behind_px = behind_m / camera.metresPerPixel(d) - ignore_px;
      if (behind_px <= 0) continue;
      const double light = 1 - kDarkest * (1 - std::exp(-behind_px / reach_px));
      auto& colour = layer.colour.at<cv::Vec3b>(y, x);
      for (int k = 0; k < 3; ++k) colour[k] = cv::saturate_cast<std::uint8_t>(light * colour[k]);
    }
}

void layOver(Layer& surface, const Layer& lines, int rim_px) {
  const cv::Mat mask = lines.depth > 0;
  cv::Mat rim;
  cv::dilate(mask, rim,
             cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * rim_px + 1, 2 * rim_px + 1}));
  for (int y = 0; y < mask.rows; ++y)
    for (int x = 0; x < mask.cols; ++x) {
      if (rim.at<std::uint8_t>(y, x) == 0) continue;
      auto& colour = surface.colour.at<cv::Vec3b>(y, x);
      if (mask.at<std::uint8_t>(y, x) == 0) {
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

}  // namespace cf
