// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "run_surface.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "cf/base/error.h"
#include "cf/formats/float_raster.h"
#include "cf/formats/tile_store.h"
#include "cf/geodesy/grid_frame.h"
#include "statistics.h"
#include "world_origin.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
constexpr int kReach = 2, kBend = 4;  ///< cells: of edges, and of what matching rounds off
constexpr double kThickness = 3;      ///< cells: points that make a cell's height
constexpr int kNeighboursNeeded = 3;  ///< of 3 x 3 cells, measured

/// Sum of the confidences of the points at the surface of each cell that so many views saw.
cv::Mat confidenceOf(const fs::path& out_dir, const HeightGrid& dsm, const GridFrame& grid,
                     int min_views) {
  cv::Mat confidence = cv::Mat::zeros(dsm.heights.size(), CV_32FC1);
  DirectoryTileStore cloud = DirectoryTileStore::open(out_dir / "cloud");
  for (const TileIndex index : cloud.indices()) {
    const auto tile = cloud.load(index);
    if (!tile || tile->points.empty()) continue;
    const Eigen::Affine3d T =
        grid.T_grid_world(tile->offset_m + tile->points.front().position_m.cast<double>()) *
        Eigen::Translation3d(tile->offset_m);
    for (const TilePoint& point : tile->points) {
      if (point.views < min_views) continue;
      const Eigen::Vector3d p = T * point.position_m.cast<double>();
      const double x = std::floor((p.x() - dsm.west_m) / dsm.spacing_m),
                   y = std::floor((dsm.north_m - p.y()) / dsm.spacing_m);
      if (!(x >= 0 && y >= 0 && x < confidence.cols && y < confidence.rows)) continue;
      const int u = static_cast<int>(x), v = static_cast<int>(y);
      const auto z = static_cast<double>(dsm.heights.at<float>(v, u));
      if (std::abs(p.z() - z) < kThickness * dsm.spacing_m)
        confidence.at<float>(v, u) += point.confidence;
    }
  }
  return confidence;
}

cv::Mat varianceOf(const cv::Mat& confidence, const cv::Mat& heights) {
  cv::Mat variance(confidence.size(), CV_32FC1, cv::Scalar(kNone));
  tbb::parallel_for(1, confidence.rows - 1, [&](int y) {
    for (int x = 1; x + 1 < confidence.cols; ++x) {
      if (std::isnan(heights.at<float>(y, x))) continue;
      int count = 0;
      float sum = 0;
      for (int v = y - 1; v <= y + 1; ++v)
        for (int u = x - 1; u <= x + 1; ++u) {
          const float c = confidence.at<float>(v, u);
          if (!(c > 0)) continue;
          sum += 1 / c;
          ++count;
        }
      if (count >= kNeighboursNeeded) variance.at<float>(y, x) = sum / static_cast<float>(count);
    }
  });
  return variance;
}

/// Least and greatest height over 5 x 5 cells.
std::pair<float, float> rangeAround(const cv::Mat& heights, int x, int y) {
  float low = std::numeric_limits<float>::max(), high = -low;
  for (int v = std::max(0, y - kReach); v <= std::min(heights.rows - 1, y + kReach); ++v)
    for (int u = std::max(0, x - kReach); u <= std::min(heights.cols - 1, x + kReach); ++u) {
      const float z = heights.at<float>(v, u);
      if (std::isnan(z)) continue;
      low = std::min(low, z);
      high = std::max(high, z);
    }
  return {low, high};
}

/// How far a height is from the mean of those to both sides, in the worst direction.
float bendAt(const cv::Mat& heights, int x, int y) {
  const cv::Rect all({0, 0}, heights.size());
  float bend = 0;
  for (const cv::Point d : {cv::Point(kBend, 0), cv::Point(0, kBend), cv::Point(kBend, kBend),
                            cv::Point(kBend, -kBend)}) {
    const cv::Point here(x, y);
    if (!all.contains(here + d) || !all.contains(here - d)) continue;
    const float mean = (heights.at<float>(here + d) + heights.at<float>(here - d)) / 2;
    if (!std::isnan(mean)) bend = std::max(bend, std::abs(mean - heights.at<float>(here)));
  }
  return bend;
}

void findSteps(RunSurface& s) {
  const cv::Mat& heights = s.heights.heights;
  s.step = cv::Mat(heights.size(), CV_32FC1, cv::Scalar(kNone));
  s.edge = cv::Mat::zeros(heights.size(), CV_8UC1);
  const auto slope = static_cast<float>(std::sqrt(2.0) * s.cell());  // of 45 degrees, diagonally
  tbb::parallel_for(0, heights.rows, [&](int y) {
    for (int x = 0; x < heights.cols; ++x) {
      if (std::isnan(heights.at<float>(y, x))) continue;
      const auto [low, high] = rangeAround(heights, x, y);
      const float range = high - low, bend = bendAt(heights, x, y);
      const bool edge = range > 2 * kReach * slope;
      s.edge.at<uchar>(y, x) = edge || bend > kBend * slope ? 1 : 0;
      s.step.at<float>(y, x) = edge ? range / 2 : std::hypot(range / 8, bend / 2);
    }
  });
  std::vector<double> usual;
  for (int y = 0; y < heights.rows; ++y)
    for (int x = 0; x < heights.cols; ++x)
      if (!std::isnan(s.step.at<float>(y, x)) && s.edge.at<uchar>(y, x) == 0)
        usual.push_back(static_cast<double>(s.step.at<float>(y, x)));
  if (usual.empty()) return;
  const auto noise = static_cast<float>(median(std::move(usual)));
  for (auto step = s.step.begin<float>(); step != s.step.end<float>(); ++step)
    *step = std::sqrt(std::max(0.F, *step * *step - noise * noise));
}

/// Means of blocks of n x n values; none where fewer than half have one.
cv::Mat blockMeans(const cv::Mat& values, int n) {
  cv::Mat means(values.rows / n, values.cols / n, CV_32FC1, cv::Scalar(kNone));
  for (int y = 0; y < means.rows; ++y)
    for (int x = 0; x < means.cols; ++x) {
      double sum = 0;
      int count = 0;
      for (int v = y * n; v < (y + 1) * n; ++v)
        for (int u = x * n; u < (x + 1) * n; ++u) {
          const float value = values.at<float>(v, u);
          if (std::isnan(value)) continue;
          sum += static_cast<double>(value);
          ++count;
        }
      if (2 * count >= n * n) means.at<float>(y, x) = static_cast<float>(sum / count);
    }
  return means;
}

}  // namespace

RunSurface readRunSurface(const fs::path& out_dir, int min_views) {
  const fs::path file = out_dir / "dsm.tif";
  const auto world = worldFrameOf(out_dir);
  if (!world)
    throw RunError(
        out_dir.string() +
        ": has no place on earth (world.json gives no origin), so it cannot be compared");
  if (!fs::exists(file))
    throw RunError(file.string() + ": is not there: run with -s deliver.dsm=1");
  const FloatRaster raster = readFloatRaster(file);
  if (!raster.geotransform || raster.crs_wkt_or_epsg.empty())
    throw RunError(file.string() + ": says not where it lies");
  RunSurface surface;
  const auto& g = *raster.geotransform;
  surface.heights = {g[0], g[3], g[1], raster.values, 0, 0};
  surface.crs = raster.crs_wkt_or_epsg;
  const auto datum = raster.metadata.find("HEIGHT_DATUM");
  surface.height_datum = datum == raster.metadata.end() ? "unknown" : datum->second;
  const GridFrame grid(*world, HeightDatum::kUnknown);
  surface.variance =
      varianceOf(confidenceOf(out_dir, surface.heights, grid, min_views), raster.values);
  findSteps(surface);
  return surface;
}

RunSurface averaged(const RunSurface& surface, double cell_m) {
  const int n = static_cast<int>(cell_m / surface.cell() + 1e-6);
  if (n < 2) return surface;
  RunSurface coarse = surface;
  coarse.heights.spacing_m *= n;
  coarse.heights.heights = blockMeans(surface.heights.heights, n);
  coarse.variance = blockMeans(surface.variance, n) / (n * n);
  findSteps(coarse);
  return coarse;
}

}  // namespace cf
