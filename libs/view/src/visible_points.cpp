// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "visible_points.h"

#include <cmath>
#include <cstdint>
#include <limits>

namespace cf {
namespace {

constexpr std::uint32_t kUnseen = std::numeric_limits<std::uint32_t>::max();

struct Cell {
  float depth_m = std::numeric_limits<float>::infinity();
  std::uint32_t nearest = kUnseen;
  std::uint32_t rgb[3] = {0, 0, 0};
  std::uint32_t count = 0;
};

/// The camera's axes in floats, relative to its eye: a cloud's points are floats too.
struct Projection {
  explicit Projection(const ViewCamera& camera)
      : right(camera.right().cast<float>()),
        up(camera.up().cast<float>()),
        forward(camera.forward().cast<float>()),
        eye(camera.eye().cast<float>()),
        near_m(static_cast<float>(camera.near_m)),
        far_m(static_cast<float>(camera.far_m)),
        parallel_m(camera.orthographic ? static_cast<float>(camera.metresPerPixel(1)) : 0),
        perspective(camera.orthographic ? 0 : static_cast<float>(camera.metresPerPixel(1))) {}

  float metresPerPixel(float depth_m) const { return parallel_m + perspective * depth_m; }

  Eigen::Vector3f right, up, forward, eye;
  float near_m, far_m;
  float parallel_m, perspective;
};

}  // namespace

std::vector<ColouredPoint> visiblePoints(const std::vector<ColouredPoint>& cloud,
                                         const ViewCamera& camera, int cell_px) {
  const Projection projection(camera);
  const int columns = (camera.size.width + cell_px - 1) / cell_px;
  const int rows = (camera.size.height + cell_px - 1) / cell_px;
  // Pixel edges, not centres: x in [0, width).
  const float half_width = 0.5F * static_cast<float>(camera.size.width);
  const float half_height = 0.5F * static_cast<float>(camera.size.height);
  const float per_cell = 1 / static_cast<float>(cell_px);
  std::vector<Cell> cells(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  std::vector<std::uint32_t> cell_of(cloud.size(), kUnseen);
  const auto depthOf = [&](const ColouredPoint& point) {
    return projection.forward.dot(point.position_m - projection.eye);
  };
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f d = cloud[i].position_m - projection.eye;
    const float depth = projection.forward.dot(d);
    if (!(depth > projection.near_m && depth < projection.far_m)) continue;
    const float scale = per_cell / projection.metresPerPixel(depth);
    const float x = half_width * per_cell + projection.right.dot(d) * scale;
    const float y = half_height * per_cell - projection.up.dot(d) * scale;
    if (!(x >= 0 && y >= 0 && x < static_cast<float>(columns) && y < static_cast<float>(rows)))
      continue;
    cell_of[i] = static_cast<std::uint32_t>(y) * static_cast<std::uint32_t>(columns) +
                 static_cast<std::uint32_t>(x);
    Cell& cell = cells[cell_of[i]];
    if (depth >= cell.depth_m) continue;
    cell.depth_m = depth;
    cell.nearest = static_cast<std::uint32_t>(i);
  }
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (cell_of[i] == kUnseen) continue;
    Cell& cell = cells[cell_of[i]];
    const float reach_m =
        static_cast<float>(kSurfaceCells * cell_px) * projection.metresPerPixel(cell.depth_m);
    if (depthOf(cloud[i]) > cell.depth_m + reach_m) continue;
    for (int k = 0; k < 3; ++k) cell.rgb[k] += cloud[i].rgb[k];
    ++cell.count;
  }
  std::vector<ColouredPoint> visible;
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const Cell& cell = cells[c];
    if (cell.nearest == kUnseen) continue;
    const float metres = projection.metresPerPixel(cell.depth_m);
    const auto size = static_cast<float>(cell_px);
    const float x = (static_cast<float>(c % static_cast<std::size_t>(columns)) + 0.5F) * size;
    const float y = (static_cast<float>(c / static_cast<std::size_t>(columns)) + 0.5F) * size;
    ColouredPoint point;
    point.position_m = projection.eye + cell.depth_m * projection.forward +
                       (x - half_width) * metres * projection.right +
                       (half_height - y) * metres * projection.up;
    for (int k = 0; k < 3; ++k)
      point.rgb[k] = static_cast<std::uint8_t>((cell.rgb[k] + cell.count / 2) / cell.count);
    visible.push_back(point);
  }
  return visible;
}

}  // namespace cf
