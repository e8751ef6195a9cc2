// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace cf {

/// Balanced k-d tree of float points in 2 or 3 dimensions, reordered in place so that the points of
/// a leaf are neighbours in memory. Distances are squared metres.
template <int Dim>
class KdTree {
 public:
  using Point = Eigen::Matrix<float, Dim, 1>;
  static constexpr float kUnlimited = std::numeric_limits<float>::max();

  explicit KdTree(std::vector<Point> points);

  /// In the tree's own order, to which the indices below refer.
  const std::vector<Point>& points() const { return points_; }
  /// Squared distance of the nearest point, or `limit2` where none is nearer than that.
  float nearestDistance2(const Point& query, float limit2 = kUnlimited) const;
  /// Up to `k` points nearer than `limit2`, as (squared distance, index), nearest first.
  void nearest(const Point& query, std::size_t k, float limit2,
               std::vector<std::pair<float, std::uint32_t>>& found) const;

 private:
  struct Node {
    float split = 0;
    int axis = -1;  ///< -1: a leaf
  };
  void build(std::size_t node, std::size_t begin, std::size_t end);
  template <class Visit>
  void search(const Point& query, std::size_t node, std::size_t begin, std::size_t end,
              Point& offset, float distance2, float& limit2, const Visit& visit) const;

  std::vector<Point> points_;
  std::vector<Node> nodes_;  ///< children of i are 2i+1 and 2i+2; ranges halve
};

extern template class KdTree<2>;
extern template class KdTree<3>;

}  // namespace cf
