// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "overlay.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "cf/view/render.h"

namespace cf {
namespace {

const cv::Scalar kInk(240, 240, 240);
constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;

// Sizes are for a picture 1080 pixels high.
double unit(const cv::Mat& picture) { return picture.rows / 1080.0; }
int scaled(const cv::Mat& picture, double px) {
  return std::max(1, static_cast<int>(std::lround(px * unit(picture))));
}

cv::Size textSize(const cv::Mat& picture, const std::string& text) {
  int below = 0;
  return cv::getTextSize(text, kFont, 0.75 * unit(picture), scaled(picture, 1.6), &below);
}

// A dark panel that lets the map through a little, so that the writing is read on any ground.
void panel(cv::Mat& picture, cv::Rect area) {
  area &= cv::Rect(0, 0, picture.cols, picture.rows);
  if (area.empty()) return;
  cv::Mat part = picture(area);
  part.convertTo(part, -1, 0.30, 8);
}

void write(cv::Mat& picture, const std::string& text, cv::Point left_base) {
  cv::putText(picture, text, left_base, kFont, 0.75 * unit(picture), kInk, scaled(picture, 1.6),
              cv::LINE_AA);
}

}  // namespace

double roundBelow(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double step : {5.0, 2.0})
    if (step * power <= value * (1 + 1e-9)) return step * power;
  return power;
}

void drawUavLegend(cv::Mat& picture, const SceneInputs& scene, bool at_bottom) {
  if (scene.tracks.empty()) return;
  const std::size_t kMost = 12;
  const std::size_t rows = std::min(kMost, scene.tracks.size());
  const bool links = !scene.links.empty();
  const int pitch = scaled(picture, 34), margin = scaled(picture, 24), mark = scaled(picture, 40);
  std::vector<std::pair<std::string, cv::Scalar>> lines;
  std::size_t index = 0;
  for (const auto& track : scene.tracks) {
    const auto rgb = uavColour(track.central, index);
    if (!track.central) ++index;
    if (lines.size() < rows)
      lines.push_back(
          {track.name + (track.central ? " (central)" : ""), cv::Scalar(rgb[2], rgb[1], rgb[0])});
  }
  if (links) lines.push_back({"relative poses", cv::Scalar(30, 30, 255)});
  if (rows < scene.tracks.size())
    lines.push_back({fmt::format("and {} more UAVs", scene.tracks.size() - rows), kInk});
  int width = 0;
  for (const auto& line : lines) width = std::max(width, textSize(picture, line.first).width);
  const int height = pitch * static_cast<int>(lines.size());
  const int top = at_bottom ? picture.rows - height - 2 * margin : 0;
  panel(picture, {margin / 2, top + margin / 2, width + mark + 2 * margin, height + margin});
  int y = top + margin + pitch / 2;
  for (const auto& [text, colour] : lines) {
    cv::line(picture, {margin, y}, {margin + mark * 3 / 4, y}, colour, scaled(picture, 5),
             cv::LINE_AA);
    write(picture, text, {margin + mark + scaled(picture, 4), y + scaled(picture, 8)});
    y += pitch;
  }
}

void drawScaleBar(cv::Mat& picture, const ViewCamera& camera) {
  if (!camera.orthographic) return;
  const double metres_per_pixel = camera.height_m / picture.rows;
  const double length_m = roundBelow(0.16 * picture.cols * metres_per_pixel);
  const int length = static_cast<int>(std::lround(length_m / metres_per_pixel));
  const std::string text =
      length_m < 1000 ? fmt::format("{:g} m", length_m) : fmt::format("{:g} km", length_m / 1000);
  const int margin = scaled(picture, 24), tick = scaled(picture, 12);
  const int y = picture.rows - 2 * margin;
  const int width = std::max(length, textSize(picture, text).width);
  const int top = y - tick - scaled(picture, 40);
  panel(picture, {margin / 2, top, width + 2 * margin, picture.rows - top - margin / 2});
  const int x = margin + margin / 2;
  const int thick = scaled(picture, 3);
  cv::line(picture, {x, y}, {x + length, y}, kInk, thick, cv::LINE_AA);
  cv::line(picture, {x, y - tick}, {x, y}, kInk, thick, cv::LINE_AA);
  cv::line(picture, {x + length, y - tick}, {x + length, y}, kInk, thick, cv::LINE_AA);
  const int text_x = x + (length - textSize(picture, text).width) / 2;
  write(picture, text, {std::max(x, text_x), y - tick - scaled(picture, 8)});
}

void drawNorthArrow(cv::Mat& picture, const ViewCamera& camera) {
  const Eigen::Vector3d north = Eigen::Vector3d::UnitY();
  Eigen::Vector2d direction(north.dot(camera.right()), -north.dot(camera.up()));
  if (direction.norm() < 0.3) return;
  direction.normalize();
  const double half = scaled(picture, 36);
  const int box = scaled(picture, 150), margin = scaled(picture, 12);
  panel(picture, {picture.cols - box - margin, margin, box, box});
  const Eigen::Vector2d centre(picture.cols - margin - box / 2.0, margin + box / 2.0);
  const Eigen::Vector2d side(-direction.y(), direction.x());
  const auto at = [](const Eigen::Vector2d& p) {
    return cv::Point(static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y())));
  };
  const Eigen::Vector2d tip = centre + half * direction;
  const Eigen::Vector2d notch = centre - 0.45 * half * direction;
  const Eigen::Vector2d left = centre - half * direction + 0.55 * half * side;
  const Eigen::Vector2d right = centre - half * direction - 0.55 * half * side;
  const std::vector<cv::Point> light = {at(tip), at(left), at(notch)};
  const std::vector<cv::Point> dark = {at(tip), at(right), at(notch)};
  cv::fillConvexPoly(picture, light, kInk, cv::LINE_AA);
  cv::fillConvexPoly(picture, dark, cv::Scalar(130, 130, 130), cv::LINE_AA);
  const cv::Size n = textSize(picture, "N");
  const cv::Point label = at(centre + 1.6 * half * direction);
  write(picture, "N", {label.x - n.width / 2, label.y + n.height / 2});
}

void drawHeightLegend(cv::Mat& picture, const HeightRange& range, const SceneInputs& scene) {
  const bool absolute = scene.height_datum == "ellipsoid" || scene.height_datum == "msl";
  const double shift = absolute ? scene.origin_height_m : 0;
  const std::string title = scene.height_datum == "ellipsoid" ? "m above ellipsoid"
                            : scene.height_datum == "msl"     ? "m above sea level"
                            : scene.georeferenced             ? "world z [m]"
                                                              : "z (no scale)";
  const int bar_width = scaled(picture, 30), bar_height = scaled(picture, 420);
  const int margin = scaled(picture, 24);
  const int width = std::max(textSize(picture, title).width, 5 * bar_width) + 2 * margin;
  const cv::Rect area(picture.cols - width - margin / 2,
                      (picture.rows - bar_height) / 2 - 3 * margin, width, bar_height + 4 * margin);
  panel(picture, area);
  write(picture, title, {area.x + margin, area.y + margin + scaled(picture, 10)});
  const cv::Rect bar(area.x + margin, area.y + 5 * margin / 2, bar_width, bar_height);
  cv::Mat ramp;
  cv::flip(heightRamp(), ramp, 0);
  cv::resize(ramp, ramp, bar.size(), 0, 0, cv::INTER_LINEAR);
  ramp.copyTo(picture(bar));
  const double low = range.min_m + shift, high = range.max_m + shift;
  const double step = roundBelow((high - low) / 3);
  const int decimals = std::max(0, static_cast<int>(-std::floor(std::log10(step) + 1e-9)));
  for (double tick = std::ceil(low / step - 1e-9) * step; tick <= high + 1e-9; tick += step) {
    const int y = bar.y + bar.height -
                  static_cast<int>(std::lround((tick - low) / (high - low) * bar.height));
    cv::line(picture, {bar.x + bar.width, y}, {bar.x + bar.width + scaled(picture, 8), y}, kInk,
             scaled(picture, 2), cv::LINE_AA);
    write(picture, fmt::format("{:.{}f}", tick + 0.0, decimals),
          {bar.x + bar.width + scaled(picture, 18), y + scaled(picture, 8)});
  }
}

}  // namespace cf
