// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "change_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "cf/formats/atomic_file.h"
#include "statistics.h"

namespace cf {
namespace {

constexpr int kLongest_px = 1600, kLegend_px = 64, kNarrowest_px = 620;
constexpr std::size_t kNumbered = 9;
const cv::Vec3d kGain(200, 90, 20), kLoss(30, 30, 215);  // blue, green, red
const cv::Scalar kPaper(255, 255, 255), kInk(40, 40, 40);

/// Light from the north-west, 45 degrees high; 0 where there is no height.
cv::Mat shaded(const cv::Mat& z, double cell_m) {
  cv::Mat out = cv::Mat::zeros(z.size(), CV_8UC1);
  for (int y = 0; y < z.rows; ++y)
    for (int x = 0; x < z.cols; ++x) {
      const auto here = static_cast<double>(z.at<float>(y, x));
      if (std::isnan(here)) continue;
      const auto at = [&](int u, int v) {
        const auto height = static_cast<double>(
            z.at<float>(std::clamp(v, 0, z.rows - 1), std::clamp(u, 0, z.cols - 1)));
        return std::isnan(height) ? here : height;
      };
      const double east = (at(x + 1, y) - at(x - 1, y)) / (2 * cell_m),
                   north = (at(x, y - 1) - at(x, y + 1)) / (2 * cell_m);
      const double light =
          (0.5 * east - 0.5 * north + std::sqrt(0.5)) / std::sqrt(1 + east * east + north * north);
      out.at<uchar>(y, x) = static_cast<uchar>(60 + 180 * std::clamp(light, 0.0, 1.0));
    }
  return out;
}

/// The colour of a change over a grey.
cv::Vec3b tinted(double grey, double change_m, double full_m) {
  const double share = 0.45 + 0.5 * std::min(1.0, std::abs(change_m) / full_m);
  const cv::Vec3d colour = change_m > 0 ? kGain : kLoss;
  cv::Vec3b out;
  for (int k = 0; k < 3; ++k)
    out[k] = cv::saturate_cast<uchar>((1 - share) * grey + share * colour[k] * (0.5 + grey / 400));
  return out;
}

void write(cv::Mat& image, const std::string& text, cv::Point at, double size,
           const cv::Scalar& colour) {
  cv::putText(image, text, at, cv::FONT_HERSHEY_SIMPLEX, size, colour, 1, cv::LINE_AA);
}

/// A scale from loss to gain, and what the greys are.
void drawLegend(cv::Mat& image, double full_m, double pixel_m) {
  const int top = image.rows - kLegend_px;
  image.rowRange(top, image.rows).setTo(kPaper);
  constexpr int kLeft = 16, kWidth = 240, kBar = 14;
  for (int x = 0; x < kWidth; ++x) {
    const double d = (2.0 * x / (kWidth - 1) - 1) * full_m;
    image(cv::Rect(kLeft + x, top + 14, 1, kBar)) = cv::Scalar(tinted(200, d, full_m));
  }
  write(image, fmt::format("-{:.2g} m", full_m), {kLeft, top + 48}, 0.45, kInk);
  write(image, "B lower | higher", {kLeft + 66, top + 48}, 0.4, kInk);
  write(image, fmt::format("+{:.2g} m", full_m), {kLeft + kWidth - 52, top + 48}, 0.45, kInk);
  image(cv::Rect(290, top + 14, 20, kBar)) = cv::Scalar(200, 200, 200);
  write(image, "no significant change", {316, top + 26}, 0.4, kInk);
  image(cv::Rect(290, top + 36, 20, kBar)) = cv::Scalar(90, 90, 90);
  write(image, "not measured by both", {316, top + 48}, 0.4, kInk);
  // A rule of a round length, about 80 pixels.
  double rule_m = std::pow(10, std::floor(std::log10(80 * pixel_m)));
  for (const double factor : {5.0, 2.0})
    if (factor * rule_m <= 100 * pixel_m) {
      rule_m *= factor;
      break;
    }
  const int length = static_cast<int>(std::lround(rule_m / pixel_m));
  cv::rectangle(image, cv::Rect(490, top + 18, length, 4), kInk, cv::FILLED);
  write(image, fmt::format("{:g} m", rule_m), {490, top + 48}, 0.45, kInk);
}

}  // namespace

void writeChangePicture(const std::filesystem::path& path, const HeightChange& change,
                        const ChangeRegions& regions) {
  const cv::Mat grey = shaded(change.height, change.cell_m);
  std::vector<double> magnitudes;
  for (int y = 0; y < grey.rows; ++y)
    for (int x = 0; x < grey.cols; ++x)
      if (regions.label.at<int>(y, x) > 0)
        magnitudes.push_back(std::abs(static_cast<double>(change.difference.at<float>(y, x))));
  const double full_m = magnitudes.empty() ? 1 : std::max(0.1, quantile(magnitudes, 0.95));
  cv::Mat colours(grey.size(), CV_8UC3, kPaper);
  for (int y = 0; y < grey.rows; ++y)
    for (int x = 0; x < grey.cols; ++x) {
      const double g = grey.at<uchar>(y, x);
      const float d = change.difference.at<float>(y, x);
      if (regions.label.at<int>(y, x) > 0)
        colours.at<cv::Vec3b>(y, x) = tinted(g, static_cast<double>(d), full_m);
      else if (g > 0)
        colours.at<cv::Vec3b>(y, x) =
            cv::Vec3b::all(cv::saturate_cast<uchar>(std::isnan(d) ? 0.45 * g : g));
    }
  const double scale =
      std::min(1.0, kLongest_px / static_cast<double>(std::max(colours.cols, colours.rows)));
  cv::Mat small;
  cv::resize(colours, small, {}, scale, scale, cv::INTER_AREA);
  for (std::size_t k = 0; k < std::min(kNumbered, regions.regions.size()); ++k) {
    const Eigen::Vector2d& middle = regions.regions[k].middle_m;
    const cv::Point at(static_cast<int>((middle.x() - change.west_m) / change.cell_m * scale) - 6,
                       static_cast<int>((change.north_m - middle.y()) / change.cell_m * scale) + 6);
    cv::putText(small, fmt::format("{}", k + 1), at, cv::FONT_HERSHEY_SIMPLEX, 0.6, kPaper, 4,
                cv::LINE_AA);
    write(small, fmt::format("{}", k + 1), at, 0.6, cv::Scalar(0, 0, 0));
  }
  cv::Mat image(small.rows + kLegend_px, std::max(small.cols, kNarrowest_px), CV_8UC3, kPaper);
  small.copyTo(image(cv::Rect({0, 0}, small.size())));
  drawLegend(image, full_m, change.cell_m / scale);
  std::vector<uchar> bytes;
  cv::imencode(".png", image, bytes);
  writeFileAtomically(path, std::string(bytes.begin(), bytes.end()));
}

}  // namespace cf
