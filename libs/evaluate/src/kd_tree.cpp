// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "kd_tree.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>

namespace cf {
namespace {

constexpr std::size_t kLeafSize = 16;
constexpr std::size_t kParallelSize = 100'000;

}  // namespace

template <int Dim>
KdTree<Dim>::KdTree(std::vector<Point> points) : points_(std::move(points)) {
  std::size_t leaves = 1;
  while (leaves * kLeafSize < points_.size()) leaves *= 2;
  nodes_.resize(2 * leaves - 1);
  build(0, 0, points_.size());
}

template <int Dim>
void KdTree<Dim>::build(std::size_t node, std::size_t begin, std::size_t end) {
  if (2 * node + 2 >= nodes_.size()) return;  // a leaf; above it there are at least 16 points
  Point low = Point::Constant(kUnlimited), high = -low;
  for (std::size_t i = begin; i < end; ++i) {
    low = low.cwiseMin(points_[i]);
    high = high.cwiseMax(points_[i]);
  }
  int axis = 0;
  (high - low).maxCoeff(&axis);
  const std::size_t middle = begin + (end - begin) / 2;
  const auto at = [&](std::size_t i) { return points_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(begin), at(middle), at(end),
                   [axis](const Point& a, const Point& b) { return a[axis] < b[axis]; });
  nodes_[node] = {points_[middle][axis], axis};
  const auto left = [&] { build(2 * node + 1, begin, middle); };
  const auto right = [&] { build(2 * node + 2, middle, end); };
  if (end - begin > kParallelSize) {
    tbb::parallel_invoke(left, right);
  } else {
    left();
    right();
  }
}

template <int Dim>
template <class Visit>
void KdTree<Dim>::search(const Point& query, std::size_t node, std::size_t begin, std::size_t end,
                         Point& offset, float distance2, float& limit2, const Visit& visit) const {
  if (nodes_[node].axis < 0) {
    for (std::size_t i = begin; i < end; ++i) {
      float d2 = 0;
      for (int a = 0; a < Dim; ++a) {
        const float d = points_[i][a] - query[a];
        d2 += d * d;
      }
      if (d2 < limit2) visit(d2, static_cast<std::uint32_t>(i));
    }
    return;
  }
  const int axis = nodes_[node].axis;
  const std::size_t middle = begin + (end - begin) / 2;
  const float across = query[axis] - nodes_[node].split;
  const float before = offset[axis];
  const auto descend = [&](bool left, float d2) {
    search(query, 2 * node + (left ? 1 : 2), left ? begin : middle, left ? middle : end, offset, d2,
           limit2, visit);
  };
  descend(across < 0, distance2);
  const float beyond2 = distance2 - before * before + across * across;
  if (beyond2 >= limit2) return;
  offset[axis] = across;
  descend(across >= 0, beyond2);
  offset[axis] = before;
}

template <int Dim>
float KdTree<Dim>::nearestDistance2(const Point& query, float limit2) const {
  Point offset = Point::Zero();
  const auto visit = [&](float d2, std::uint32_t) { limit2 = d2; };
  search(query, 0, 0, points_.size(), offset, 0, limit2, visit);
  return limit2;
}

template <int Dim>
void KdTree<Dim>::nearest(const Point& query, std::size_t k, float limit2,
                          std::vector<std::pair<float, std::uint32_t>>& found) const {
  found.clear();
  Point offset = Point::Zero();
  const auto visit = [&](float d2, std::uint32_t i) {
    if (found.size() == k) {
      std::pop_heap(found.begin(), found.end());
      found.pop_back();
    }
    found.emplace_back(d2, i);
    std::push_heap(found.begin(), found.end());
    if (found.size() == k) limit2 = found.front().first;
  };
  search(query, 0, 0, points_.size(), offset, 0, limit2, visit);
  std::sort_heap(found.begin(), found.end());
}

template class KdTree<2>;
template class KdTree<3>;

}  // namespace cf
