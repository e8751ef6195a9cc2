// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "height_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cf/base/error.h"
#include "cf/base/text.h"
#include "cf/formats/float_raster.h"

namespace cf {

std::optional<double> HeightGrid::smoothHeight(const Eigen::Vector2d& place) const {
  const double x = (place.x() - west_m) / spacing_m - 0.5,
               y = (north_m - place.y()) / spacing_m - 0.5;
  if (!(x >= 0 && y >= 0 && x < heights.cols - 1 && y < heights.rows - 1)) return std::nullopt;
  const int i = static_cast<int>(x), j = static_cast<int>(y);
  const double u = x - i, v = y - j;
  const auto at = [&](int di, int dj) {
    return static_cast<double>(heights.at<float>(j + dj, i + di));
  };
  const double a = at(0, 0), b = at(1, 0), c = at(0, 1), d = at(1, 1);
  const double range = std::max({a, b, c, d}) - std::min({a, b, c, d});
  if (!std::isfinite(a + b + c + d) || range > std::sqrt(2.0) * spacing_m) return std::nullopt;
  return (1 - v) * ((1 - u) * a + u * b) + v * ((1 - u) * c + u * d);
}

std::optional<std::pair<double, double>> HeightGrid::heightRange(const Eigen::Vector2d& place,
                                                                 double reach_m) const {
  const auto cell = [&](double metres, int count) {
    return static_cast<int>(std::clamp(std::floor(metres / spacing_m), -1.0, count + 0.0));
  };
  const double x = place.x() - west_m, y = north_m - place.y();
  std::optional<std::pair<double, double>> range;
  for (int j = std::max(0, cell(y - reach_m, heights.rows));
       j <= std::min(heights.rows - 1, cell(y + reach_m, heights.rows)); ++j)
    for (int i = std::max(0, cell(x - reach_m, heights.cols));
         i <= std::min(heights.cols - 1, cell(x + reach_m, heights.cols)); ++i) {
      const auto z = static_cast<double>(heights.at<float>(j, i));
      if (!std::isfinite(z)) continue;
      range = range ? std::pair(std::min(range->first, z), std::max(range->second, z))
                    : std::pair(z, z);
    }
  return range;
}

std::optional<double> HeightGrid::firstHit(const Eigen::Vector3d& from,
                                           const Eigen::Vector3d& direction) const {
  if (!(direction.z() < 0)) return std::nullopt;
  const double begin = std::max(0.0, (greatest_m - from.z()) / direction.z());
  const double end = (least_m - from.z()) / direction.z();
  const double step = spacing_m / 2 / std::max(1e-9, direction.head<2>().norm());
  for (double t = begin, before = begin;; before = t, t = std::min(end, t + step)) {
    const Eigen::Vector3d p = from + t * direction;
    const double x = std::floor((p.x() - west_m) / spacing_m),
                 y = std::floor((north_m - p.y()) / spacing_m);
    if (x >= 0 && y >= 0 && x < heights.cols && y < heights.rows) {
      const auto z =
          static_cast<double>(heights.at<float>(static_cast<int>(y), static_cast<int>(x)));
      if (p.z() <= z + 1e-6) return std::max(before, (z - from.z()) / direction.z());
    }
    if (t >= end) return std::nullopt;
  }
}

HeightGrid readHeightGrid(const std::filesystem::path& file) {
  const FloatRaster raster = readFloatRaster(file);
  const auto number = [&](const char* key) {
    const auto item = raster.metadata.find(key);
    const auto value = item == raster.metadata.end() ? std::nullopt : numberFrom(item->second);
    if (!value)
      throw RunError(file.string() + ": needs the TIFF metadata item " + key + ", metres");
    return *value;
  };
  HeightGrid grid{number("ORIGIN_E"), number("ORIGIN_N"), number("SPACING"), raster.values, 0, 0};
  if (!(grid.spacing_m > 0)) throw RunError(file.string() + ": SPACING should be above 0");
  float least = std::numeric_limits<float>::max(), greatest = -least;
  for (auto z = grid.heights.begin<float>(); z != grid.heights.end<float>(); ++z)
    if (std::isfinite(*z)) {
      least = std::min(least, *z);
      greatest = std::max(greatest, *z);
    }
  if (least > greatest) throw RunError(file.string() + ": no cell has a height");
  grid.least_m = static_cast<double>(least);
  grid.greatest_m = static_cast<double>(greatest);
  return grid;
}

}  // namespace cf
