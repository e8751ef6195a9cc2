// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/deliver/dsm.h"

#include <fmt/format.h>
#include <tbb/parallel_pipeline.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <opencv2/core.hpp>
#include <vector>

#include "cf/base/error.h"
#include "cf/formats/geotiff.h"
#include "surface_grid.h"

namespace cf {
namespace {

constexpr int kWindowsAtOnce = 2;
/// Around a window: what the filling of holes and the filters reach.
constexpr int kMargin = DsmBuilder::kHoleReach + 4;
constexpr float kRoofStep =
    8;  ///< cells; beside an edge of such a height holes take the lower side
/// Heights are rounded to such a part of a metre, which halves the file.
constexpr float kRounding = 1024;

Eigen::Affine3d T_grid_tile(const GridFrame& grid, const Tile& tile) {
  Eigen::AlignedBox3f box;
  for (const TilePoint& p : tile.points) box.extend(p.position_m);
  return grid.T_grid_world(tile.offset_m + box.center().cast<double>()) *
         Eigen::Translation3d(tile.offset_m);
}

struct Window {
  cv::Rect area;  ///< of the raster
  cv::Mat heights;
};

}  // namespace

DsmBuilder::DsmBuilder(const GridFrame& grid, double cell_m)
    : grid_(grid), cell_m_(std::max(1., std::floor(1000 * cell_m)) / 1000) {}

void DsmBuilder::add(const Tile& tile) {
  if (tile.points.empty()) return;
  const Eigen::Affine3d T = T_grid_tile(grid_, tile);
  Eigen::AlignedBox3d box;
  for (const TilePoint& p : tile.points) box.extend(T * p.position_m.cast<double>());
  places_[tile.index] = box;
}

void DsmBuilder::write(TileStore& cloud, const std::filesystem::path& path) const {
  if (empty()) throw RunError(path.string() + ": there is no surface to write");
  Eigen::AlignedBox3d all;
  for (const auto& [index, box] : places_) all.extend(box);
  const double low_z = all.min().z();
  GeoTiffGrid raster;
  raster.cell_m = cell_m_;
  const double left = std::floor(all.min().x() / cell_m_), top = std::ceil(all.max().y() / cell_m_);
  raster.left_m = left * cell_m_;
  raster.top_m = top * cell_m_;
  raster.width = static_cast<int>(std::ceil(all.max().x() / cell_m_) - left) + 1;
  raster.height = static_cast<int>(top - std::floor(all.min().y() / cell_m_)) + 1;
  if (!grid_.relative()) raster.crs = fmt::format("EPSG:{}", grid_.epsg());
  GeoTiffWriter out(path, GeoTiffWriter::Kind::kHeights, raster,
                    {{"AREA_OR_POINT", "Area"},
                     {"HEIGHT_DATUM", name(grid_.datum())},
                     {"HOLES_FILLED_M", fmt::format("{:.3f}", kHoleReach * cell_m_)}});

  const int columns = (raster.width - 1) / kWindow + 1;
  const int windows = columns * ((raster.height - 1) / kWindow + 1);
  std::mutex store_mutex;
  const auto surfaceOf = [&](int number) {
    Window window;
    window.area =
        cv::Rect(number % columns * kWindow, number / columns * kWindow, kWindow, kWindow) &
        cv::Rect(0, 0, raster.width, raster.height);
    const cv::Rect wide(window.area.x - kMargin, window.area.y - kMargin,
                        window.area.width + 2 * kMargin, window.area.height + 2 * kMargin);
    const Eigen::Vector2d corner(raster.left_m + wide.x * cell_m_, raster.top_m - wide.y * cell_m_);
    std::vector<SurfacePoint> points;
    for (const auto& [index, box] : places_) {
      if (box.max().x() < corner.x() || box.min().x() > corner.x() + wide.width * cell_m_ ||
          box.min().y() > corner.y() || box.max().y() < corner.y() - wide.height * cell_m_)
        continue;
      std::unique_lock<std::mutex> lock(store_mutex);
      const std::optional<Tile> tile = cloud.load(index);
      lock.unlock();
      if (!tile) throw RunError(path.string() + ": a tile of the cloud is missing");
      // To cells of the window, downwards from its upper left corner.
      const Eigen::Affine3d T_window_tile = Eigen::Scaling(Eigen::Vector3d(1, -1, 1) / cell_m_) *
                                            Eigen::Translation3d(-corner.x(), -corner.y(), -low_z) *
                                            T_grid_tile(grid_, *tile);
      points.reserve(points.size() + tile->points.size());
      for (const TilePoint& p : tile->points) {
        const Eigen::Vector3f q = (T_window_tile * p.position_m.cast<double>()).cast<float>();
        if (!(q.x() >= 0 && q.y() >= 0 && q.x() < static_cast<float>(wide.width) &&
              q.y() < static_cast<float>(wide.height)))
          continue;
        points.push_back({q.x(), q.y(), q.z(), p.confidence, static_cast<float>(p.views)});
      }
    }
    if (points.empty()) return window;
    cv::Mat heights = withHolesFilled(uppermostSurface(points, wide.size()), kHoleReach, kRoofStep)(
                          cv::Rect(window.area.tl() - wide.tl(), window.area.size()))
                          .clone();
    for (int y = 0; y < heights.rows; ++y)
      for (float *z = heights.ptr<float>(y), *end = z + heights.cols; z != end; ++z)
        *z = static_cast<float>(
                 std::round((static_cast<double>(*z) * cell_m_ + low_z) * kRounding)) /
             kRounding;
    window.heights = heights;
    return window;
  };

  int next = 0;
  tbb::parallel_pipeline(
      kWindowsAtOnce,
      tbb::make_filter<void, int>(tbb::filter_mode::serial_in_order,
                                  [&](tbb::flow_control& control) {
                                    if (next == windows) control.stop();
                                    return next++;
                                  }) &
          tbb::make_filter<int, std::shared_ptr<Window>>(
              tbb::filter_mode::parallel,
              [&](int number) { return std::make_shared<Window>(surfaceOf(number)); }) &
          tbb::make_filter<std::shared_ptr<Window>, void>(
              tbb::filter_mode::serial_in_order, [&](const std::shared_ptr<Window>& window) {
                if (!window->heights.empty())
                  out.write(window->area.x, window->area.y, window->heights);
              }));
  out.close();
}

}  // namespace cf
