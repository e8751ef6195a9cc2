// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/deliver/cloud_sketch.h"

#include <cstring>

namespace cf {
namespace {

/// Bits without a pattern from the bits of a position: the last rounds of MurmurHash3.
std::uint32_t rankOf(const Eigen::Vector3f& position) {
  std::uint32_t h = 0;
  for (const float value : {position.x(), position.y(), position.z()}) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    h = (h ^ bits) * 0x9E3779B1U;
    h ^= h >> 15;
  }
  h *= 0x85EBCA6BU;
  h ^= h >> 13;
  h *= 0xC2B2AE35U;
  return h ^ h >> 16;
}

}  // namespace

void CloudSketch::add(const Tile& tile) {
  if (total_ == 0) offset_m_ = tile.offset_m;
  const Eigen::Vector3f shift = (tile.offset_m - offset_m_).cast<float>();
  total_ += tile.points.size();
  for (const TilePoint& p : tile.points) {
    confirmed_ += p.views >= 2 ? 1 : 0;
    const std::uint32_t rank = rankOf(p.position_m);
    if (rank > limit_) continue;
    points_.push_back({p.position_m + shift, {p.bgr[2], p.bgr[1], p.bgr[0]}});
    ranks_.push_back(rank);
    if (points_.size() <= kMost) continue;
    limit_ = limit_ / 4 * 3;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < points_.size(); ++i)
      if (ranks_[i] <= limit_) {
        points_[kept] = points_[i];
        ranks_[kept++] = ranks_[i];
      }
    points_.resize(kept);
    ranks_.resize(kept);
  }
}

}  // namespace cf
