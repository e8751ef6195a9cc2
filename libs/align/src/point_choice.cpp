// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "point_choice.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <utility>

namespace cf {
namespace {

constexpr int kGrid = 6;

int cellOf(const Keyframe& photo, int feature) {
  const auto& pixel = photo.features->pixel[static_cast<std::size_t>(feature)];
  const auto along = [](float at, int size) {
    return std::clamp(static_cast<int>(at * kGrid / static_cast<float>(size)), 0, kGrid - 1);
  };
  return along(pixel.y(), photo.camera.height) * kGrid + along(pixel.x(), photo.camera.width);
}

}  // namespace

std::vector<SparsePoint> choosePoints(const MatchGraph& graph,
                                      const std::vector<SparsePoint>& points,
                                      int points_per_photo) {
  const int quota = std::max(1, points_per_photo / (kGrid * kGrid));
  const auto rank = [&](std::size_t i) {
    const auto& o = points[i].observations;
    const bool crosses = std::any_of(
        o.begin(), o.end(), [&](const auto& x) { return x.frame.uav != o.front().frame.uav; });
    return std::pair(crosses, o.size());
  };
  std::vector<std::pair<std::pair<bool, std::size_t>, std::size_t>> order;
  for (std::size_t i = 0; i < points.size(); ++i) order.emplace_back(rank(i), i);
  std::stable_sort(order.begin(), order.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::map<FrameId, std::array<int, kGrid * kGrid>> used;
  std::vector<SparsePoint> chosen;
  std::vector<int*> cells;
  for (const auto& [of_point, i] : order) {
    bool wanted = false;
    cells.clear();
    for (const auto& o : points[i].observations) {
      int& cell = used[o.frame][static_cast<std::size_t>(cellOf(graph.photo(o.frame), o.feature))];
      wanted = wanted || cell < quota;
      cells.push_back(&cell);
    }
    if (!wanted) continue;
    for (int* cell : cells) ++*cell;
    chosen.push_back(points[i]);
  }
  return chosen;
}

}  // namespace cf
