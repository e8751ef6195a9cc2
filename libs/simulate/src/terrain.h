// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

namespace cf {

/// The ground: a grid of heights, each cell two triangles cut along the diagonal from its
/// south-west to its north-east corner. Coordinates are the scene's own (origin in its middle).
class Terrain {
 public:
  /// Flat (height 0) or hills from 0 to relief_m, over at least the given half extents.
  Terrain(bool hills, double relief_m, const Eigen::Vector2d& half_extent_m, std::uint64_t seed);

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  Eigen::Vector3f vertex(int column, int row) const;
  /// Corner indices (row * columns + column), three a triangle, counter-clockwise from above.
  std::vector<std::uint32_t> triangles() const;
  /// Height on the triangles; beyond the edge that of the edge.
  double height(double x, double y) const;
  /// Smooth normal for shading.
  Eigen::Vector3f normal(float x, float y) const;

 private:
  float at(int column, int row) const {
    return heights_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                    static_cast<std::size_t>(column)];
  }

  double cell_ = 2;
  int columns_ = 2, rows_ = 2;
  Eigen::Vector2d corner_ = Eigen::Vector2d::Zero();
  std::vector<float> heights_;
};

}  // namespace cf
