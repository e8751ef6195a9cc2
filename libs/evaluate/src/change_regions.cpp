// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "change_regions.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>

namespace cf {
namespace {

constexpr int kRim = 4;  ///< cells

/// +1, -1 or 0 for each cell by its difference over `sigma`.
cv::Mat signs(const cv::Mat& difference, const cv::Mat& sigma) {
  cv::Mat out = cv::Mat::zeros(difference.size(), CV_8SC1);
  const auto limit = static_cast<float>(kSignificant);
  for (int y = 0; y < out.rows; ++y)
    for (int x = 0; x < out.cols; ++x) {
      const float z = difference.at<float>(y, x) / sigma.at<float>(y, x);
      out.at<schar>(y, x) = static_cast<schar>(z >= limit ? 1 : z <= -limit ? -1 : 0);
    }
  return out;
}

/// The sign of one of the eight neighbours that equals that of `wanted` there.
cv::Mat grown(const cv::Mat& core, const cv::Mat& wanted) {
  cv::Mat out = core.clone();
  for (int y = 0; y < core.rows; ++y)
    for (int x = 0; x < core.cols; ++x) {
      const schar sign = wanted.at<schar>(y, x);
      if (sign == 0 || core.at<schar>(y, x) != 0) continue;
      for (int v = std::max(0, y - 1); v <= std::min(core.rows - 1, y + 1); ++v)
        for (int u = std::max(0, x - 1); u <= std::min(core.cols - 1, x + 1); ++u)
          if (core.at<schar>(v, u) == sign) out.at<schar>(y, x) = sign;
    }
  return out;
}

/// All cells that hang together with one, in the order found.
std::vector<cv::Point> connected(const cv::Mat& sign, cv::Point start, cv::Mat& seen) {
  std::vector<cv::Point> cells = {start};
  seen.at<uchar>(start) = 1;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const cv::Point c = cells[i];
    for (int y = std::max(0, c.y - 1); y <= std::min(sign.rows - 1, c.y + 1); ++y)
      for (int x = std::max(0, c.x - 1); x <= std::min(sign.cols - 1, c.x + 1); ++x) {
        if (seen.at<uchar>(y, x) != 0 || sign.at<schar>(y, x) != sign.at<schar>(c)) continue;
        seen.at<uchar>(y, x) = 1;
        cells.emplace_back(x, y);
      }
  }
  return cells;
}

ChangeRegion regionOf(const HeightChange& change, const SurfaceRegistration& registration,
                      const std::vector<cv::Point>& cells, const cv::Mat& sign) {
  ChangeRegion region;
  region.gain = sign.at<schar>(cells.front()) > 0;
  region.cells = cells.size();
  region.area_m2 = static_cast<double>(cells.size()) * change.area();
  double sum = 0, height = 0, rim_cells = 0;
  for (const cv::Point c : cells) {
    const auto d = static_cast<double>(change.difference.at<float>(c));
    sum += d;
    height += static_cast<double>(change.height.at<float>(c));
    if (std::abs(d) > std::abs(region.extreme_m)) region.extreme_m = d;
    region.middle_m += Eigen::Vector2d(c.x + 0.5, c.y + 0.5);
    for (const cv::Point side :
         {cv::Point(1, 0), cv::Point(0, 1), cv::Point(-1, 0), cv::Point(0, -1)})
      if (const cv::Point n = c + side;
          !cv::Rect({0, 0}, sign.size()).contains(n) || sign.at<schar>(n) != sign.at<schar>(c))
        ++rim_cells;
  }
  const auto count = static_cast<double>(cells.size());
  region.mean_m = sum / count;
  region.volume_m3 = sum * change.area();
  region.middle_m = {change.west_m + change.cell_m * region.middle_m.x() / count,
                     change.north_m - change.cell_m * region.middle_m.y() / count};
  // What moves all of it together, what has not averaged out, and half a cell all around.
  const double together = registration.heightVariance(
      {region.middle_m.x(), region.middle_m.y(), height / count}, {0, 0});
  const double mean = change.meanSigma(region.area_m2);
  const double rim = rim_cells * change.area() / 2 * region.mean_m;
  region.volume_sigma_m3 = std::hypot(region.area_m2 * std::sqrt(together + mean * mean), rim);
  return region;
}

}  // namespace

ChangeRegions changeRegions(const HeightChange& change, const SurfaceRegistration& registration,
                            double min_area_m2) {
  const cv::Mat core = signs(change.difference, change.sigma);
  const cv::Mat wanted = signs(change.difference, change.smooth_sigma);
  cv::Mat sign = core;
  for (int k = 0; k < kRim; ++k) sign = grown(sign, wanted);

  ChangeRegions found;
  std::vector<std::vector<cv::Point>> members;
  cv::Mat seen = cv::Mat::zeros(sign.size(), CV_8UC1);
  for (int y = 0; y < sign.rows; ++y)
    for (int x = 0; x < sign.cols; ++x) {
      if (sign.at<schar>(y, x) == 0 || seen.at<uchar>(y, x) != 0) continue;
      std::vector<cv::Point> cells = connected(sign, {x, y}, seen);
      const auto inner = std::count_if(cells.begin(), cells.end(),
                                       [&](cv::Point c) { return core.at<schar>(c) != 0; });
      if (static_cast<double>(cells.size()) * change.area() < min_area_m2 ||
          static_cast<double>(inner) * change.area() < min_area_m2 / 2)
        continue;
      found.regions.push_back(regionOf(change, registration, cells, sign));
      members.push_back(std::move(cells));
    }
  std::vector<std::size_t> order(members.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
    return std::abs(found.regions[i].volume_m3) > std::abs(found.regions[j].volume_m3);
  });
  found.label = cv::Mat::zeros(sign.size(), CV_32SC1);
  std::vector<ChangeRegion> sorted;
  for (const std::size_t i : order) {
    sorted.push_back(found.regions[i]);
    for (const cv::Point c : members[i])
      found.label.at<std::int32_t>(c) = static_cast<std::int32_t>(sorted.size());
  }
  found.regions = std::move(sorted);
  return found;
}

}  // namespace cf
