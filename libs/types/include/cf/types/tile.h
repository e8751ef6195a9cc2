// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace cf {

/// Tile (x, y) covers [x d, (x+1) d) x [y d, (y+1) d) of the world's horizontal plane, d being the
/// tile size: index floor(P / d), equation (10), with floor and not truncation.
struct TileIndex {
  std::int32_t x = 0;
  std::int32_t y = 0;
  friend bool operator==(TileIndex a, TileIndex b) { return a.x == b.x && a.y == b.y; }
  friend bool operator<(TileIndex a, TileIndex b) { return a.x != b.x ? a.x < b.x : a.y < b.y; }
};

struct TilePoint {
  Eigen::Vector3f position_m = Eigen::Vector3f::Zero();  ///< relative to Tile::offset_m
  std::uint8_t bgr[3] = {0, 0, 0};
  std::uint16_t views = 0;  ///< depth frames that saw it
  float confidence = 0;     ///< sum of the weights of what was merged into it
};

/// Part of the fused map.
struct Tile {
  TileIndex index;
  Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();  ///< world
  std::vector<TilePoint> points;
};

}  // namespace cf
