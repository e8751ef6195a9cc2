// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "height_grid.h"

#include <algorithm>
#include <cmath>

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

HeightGrid readHeightGrid(const std::filesystem::path& file) {
  const FloatRaster raster = readFloatRaster(file);
  const auto number = [&](const char* key) {
    const auto item = raster.metadata.find(key);
    const auto value = item == raster.metadata.end() ? std::nullopt : numberFrom(item->second);
    if (!value)
      throw RunError(file.string() + ": needs the TIFF metadata item " + key + ", metres");
    return *value;
  };
  HeightGrid grid{number("ORIGIN_E"), number("ORIGIN_N"), number("SPACING"), raster.values};
  if (!(grid.spacing_m > 0)) throw RunError(file.string() + ": SPACING should be above 0");
  return grid;
}

}  // namespace cf
