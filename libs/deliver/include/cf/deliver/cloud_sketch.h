// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "cf/types/tile.h"

namespace cf {

/// A cloud thinned to at most kMost points, spread as evenly as the cloud is, and how much of the
/// whole cloud is confirmed. Which points stay depends on their places alone.
class CloudSketch {
 public:
  static constexpr std::size_t kMost = 300'000;

  struct Point {
    Eigen::Vector3f position_m = Eigen::Vector3f::Zero();  ///< relative to offset()
    std::array<std::uint8_t, 3> rgb = {0, 0, 0};
  };

  /// A tile of the finished cloud.
  void add(const Tile& tile);

  const std::vector<Point>& points() const { return points_; }
  const Eigen::Vector3d& offset() const { return offset_m_; }  ///< world
  std::size_t total() const { return total_; }                 ///< points of the whole cloud
  /// Of them, those that at least two depth frames put into the same voxel.
  std::size_t confirmed() const { return confirmed_; }

 private:
  std::vector<Point> points_;
  std::vector<std::uint32_t> ranks_;
  std::uint32_t limit_ = 0xFFFFFFFF;  ///< points of a higher rank are left out
  Eigen::Vector3d offset_m_ = Eigen::Vector3d::Zero();
  std::size_t total_ = 0, confirmed_ = 0;
};

}  // namespace cf
