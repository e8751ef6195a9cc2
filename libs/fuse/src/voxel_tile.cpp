// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "voxel_tile.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <utility>

#include "cf/base/instruction_sets.h"

namespace cf {
namespace {

/// A position of 1 falls on the last of 65536 steps.
constexpr float kPositionSteps = 65535.9F;
constexpr float kColourSteps = 257;
constexpr float kFarthest = 1 << 18;  ///< cells along z from the origin of the points

// What the processor works on at once (a language extension of g++ and clang).
using Floats = float __attribute__((vector_size(16)));
using Ints = std::int32_t __attribute__((vector_size(16)));
using MoreFloats = float __attribute__((vector_size(32)));
using MoreInts = std::int32_t __attribute__((vector_size(32)));
using Shorts = std::uint16_t __attribute__((vector_size(16)));

}  // namespace

VoxelTile::VoxelTile(TileIndex index, double tile_m, double voxel_m)
    : index_(index),
      offset_m_(index.x * tile_m, index.y * tile_m, 0),
      voxel_m_(voxel_m),
      columns_(std::max(1, static_cast<int>(std::ceil(tile_m / voxel_m)))),
      blocks_along_((static_cast<std::uint32_t>(columns_) + kBlockSide - 1) / kBlockSide),
      blocks_(std::size_t{blocks_along_} * blocks_along_) {}

/// Where a point goes, and with what.
struct VoxelTile::Arrival {
  MoreFloats values;  ///< as a voxel's last 16 bytes: nothing twice, then the means
  Voxel* column;
  Block* block;
  std::int32_t height;
  float weight;
};

/// Cells around the origin of points: cell = factor * position + shift, in floats near zero.
struct VoxelTile::Grid {
  Floats factor, shift, low, high;
  std::int32_t height;  ///< of the cell zero
  float farthest_m;     ///< along z
};

/// The running mean of all six at once: the last 16 bytes of a voxel are taken as eight numbers, of
/// which the first two, views and height, get no share. They are stored in one piece with the
/// views: what is read in larger pieces than it was just written makes the processor wait.
[[gnu::always_inline]] inline void VoxelTile::Voxel::add(const Arrival& arrival,
                                                         std::uint32_t view_stamp) {
  static_assert(offsetof(Voxel, mean) + sizeof(mean) == 24);
  constexpr MoreFloats kShared = {0, 0, 1, 1, 1, 1, 1, 1};
  weight += arrival.weight;
  const MoreFloats shares = kShared * (arrival.weight / weight);
  char* const bytes = reinterpret_cast<char*>(this);
  Shorts means;
  std::memcpy(&means, bytes + 8, sizeof(means));
  const MoreFloats before =
      __builtin_convertvector(__builtin_convertvector(means, MoreInts), MoreFloats) + 0.5F;
  const MoreFloats after = before + shares * (arrival.values - before);
  means = __builtin_convertvector(__builtin_convertvector(after, MoreInts), Shorts);
  if (stamp != view_stamp) {
    const std::uint32_t link = next | view_stamp << 24;
    std::memcpy(bytes + 4, &link, sizeof(link));
    if (views < kMaxViews) ++means[0];  // its low 12 bits
  }
  std::memcpy(bytes + 8, &means, sizeof(means));
}

VoxelTile::Grid VoxelTile::gridAround(const Eigen::Vector3d& origin_m) const {
  const Eigen::Vector3d side(voxel_m_, voxel_m_, kHeightOverSide * voxel_m_);
  const Eigen::Vector3d origin = (origin_m - offset_m_).cwiseQuotient(side);
  const double height = std::floor(origin.z());
  const Eigen::Vector3f factor = side.cwiseInverse().cast<float>();
  const Eigen::Vector3f shift = (origin - height * Eigen::Vector3d::UnitZ()).cast<float>();
  // A point on the tile's edge may fall a rounding error outside of it.
  const float edge = std::nextafter(static_cast<float>(columns_), 0.F);
  Grid grid;
  grid.factor = Floats{factor.x(), factor.y(), factor.z(), 0};
  grid.shift = Floats{shift.x(), shift.y(), shift.z(), 0};
  grid.low = Floats{0, 0, -2 * kFarthest, 0};
  grid.high = Floats{edge, edge, 2 * kFarthest, 0};
  const bool reached = std::abs(height) < kFarthest - 1;
  grid.height = reached ? static_cast<std::int32_t>(height) : 0;
  grid.farthest_m = reached ? kFarthest * static_cast<float>(side.z()) : 0;
  return grid;
}

[[gnu::always_inline]] inline bool VoxelTile::locate(const Grid& grid, const MapPoint& point,
                                                     Arrival& arrival) {
  if (!(std::abs(point.position_m.z()) < grid.farthest_m) || !(point.weight > 0) ||
      !(point.weight <= std::numeric_limits<float>::max()))
    return false;
  const Floats position = {point.position_m.x(), point.position_m.y(), point.position_m.z(), 0};
  Floats at = grid.factor * position + grid.shift;
  at = at > grid.low ? at : grid.low;
  at = at < grid.high ? at : grid.high;
  Ints cell = __builtin_convertvector(at, Ints);
  cell += __builtin_convertvector(cell, Floats) > at;  // rounds down: true is -1
  const Floats inside = (at - __builtin_convertvector(cell, Floats)) * kPositionSteps;
  const Ints bgr = {point.bgr[0], point.bgr[1], point.bgr[2], 0};
  const Floats colour = __builtin_convertvector(bgr, Floats) * kColourSteps + 0.5F;
  arrival.values =
      MoreFloats{0, 0, colour[0], colour[1], colour[2], inside[0], inside[1], inside[2]};
  arrival.height = cell[2] + grid.height;
  arrival.weight = point.weight;
  const auto i = static_cast<std::uint32_t>(cell[0]), j = static_cast<std::uint32_t>(cell[1]);
  std::unique_ptr<Block>& block = blocks_[j / kBlockSide * blocks_along_ + i / kBlockSide];
  if (!block) {
    block = std::make_unique<Block>();
    ++filled_blocks_;
  }
  arrival.block = block.get();
  arrival.column = &block->columns[j % kBlockSide * kBlockSide + i % kBlockSide];
  return true;
}

/// Null where the tile is full. A voxel that outweighs the one before it changes places with it.
[[gnu::always_inline]] inline VoxelTile::Voxel* VoxelTile::voxelAt(const Arrival& arrival) {
  Voxel& column = *arrival.column;
  const std::int32_t height = arrival.height;
  if (column.height == height && column.weight > 0) return &column;
  if (column.weight == 0) {
    column.height = height;
    ++size_;
    return &column;
  }
  Voxel* above = &column;
  for (std::uint32_t number = column.next; number != kNone;) {
    Voxel& found = voxel(number);
    if (found.height != height) {
      number = found.next;
      above = &found;
      continue;
    }
    if (found.weight <= above->weight) return &found;
    const std::uint32_t to_found = above->next, onward = found.next;
    std::swap(found, *above);
    above->next = to_found;
    found.next = onward;
    return above;
  }
  std::uint32_t& free = arrival.block->free;
  if (free % kChunkVoxels == 0) {
    if (room_ + kChunkVoxels > kNone) return nullptr;
    if (room_ % kSlabVoxels == 0) slabs_.push_back(std::make_unique<Slab>());
    free = room_;
    room_ += kChunkVoxels;
  }
  Voxel& added = voxel(free);
  added.height = height;
  added.next = column.next;
  column.next = free++;
  ++size_;
  return &added;
}

void VoxelTile::startView(std::uint32_t view) {
  if (stamp_ != 0 && view == view_) return;
  view_ = view;
  if (stamp_ == kMaxStamp) {  // from the beginning: what they stood for has passed
    for (const auto& block : blocks_)
      if (block)
        for (Voxel& v : block->columns) v.stamp = 0;
    for (const auto& slab : slabs_)
      for (Voxel& v : *slab) v.stamp = 0;
    stamp_ = 0;
  }
  ++stamp_;
}

std::size_t VoxelTile::add(const Eigen::Vector3d& origin_m, const MapPoint* begin,
                           const MapPoint* end, std::uint32_t view) {
  startView(view);
  return merge(gridAround(origin_m), begin, end);
}

CF_CLONES std::size_t VoxelTile::merge(const Grid& grid, const MapPoint* begin,
                                       const MapPoint* end) {
  // In groups, each memory access asked for ahead of its use: waiting for them is most of the time.
  constexpr std::size_t kAtOnce = 64;
  std::array<Arrival, kAtOnce> arrivals;
  std::size_t merged = 0;
  while (begin != end) {
    std::size_t n = 0;
    for (; begin != end && n < kAtOnce; ++begin) {
      if (!locate(grid, *begin, arrivals[n])) continue;
      __builtin_prefetch(arrivals[n].column, 1);
      ++n;
    }
    for (std::size_t k = 0; k < n; ++k) {
      const Voxel& column = *arrivals[k].column;
      if (column.height != arrivals[k].height && column.next != kNone)
        __builtin_prefetch(&voxel(column.next), 1);
    }
    for (std::size_t k = 0; k < n; ++k) {
      const Arrival& arrival = arrivals[k];
      Voxel* const to = voxelAt(arrival);
      if (!to) continue;
      ++merged;
      to->add(arrival, stamp_);
    }
  }
  return merged;
}

TilePoint VoxelTile::pointOf(const Voxel& v, std::uint32_t i, std::uint32_t j) const {
  const auto along = [](auto cell, std::uint16_t mean, double side_m) {
    return static_cast<float>(side_m * (cell + (mean + 0.5) * (1.0 / double{kPositionSteps})));
  };
  TilePoint point;
  point.position_m = {along(i, v.mean[3], voxel_m_), along(j, v.mean[4], voxel_m_),
                      along(v.height, v.mean[5], kHeightOverSide * voxel_m_)};
  for (int c = 0; c < 3; ++c)
    point.bgr[c] = static_cast<std::uint8_t>((v.mean[c] + 128) / static_cast<int>(kColourSteps));
  point.views = static_cast<std::uint16_t>(v.views);
  point.confidence = v.weight;
  return point;
}

Tile VoxelTile::toTile() const {
  Tile tile;
  tile.index = index_;
  tile.offset_m = offset_m_;
  tile.points.reserve(size_);
  std::vector<const Voxel*> column;
  for (std::uint32_t b = 0; b < blocks_.size(); ++b) {
    const Block* block = blocks_[b].get();
    if (!block) continue;
    for (std::uint32_t c = 0; c < kBlockSide * kBlockSide; ++c) {
      const Voxel& heaviest = block->columns[c];
      if (heaviest.weight == 0) continue;
      const std::uint32_t i = b % blocks_along_ * kBlockSide + c % kBlockSide;
      const std::uint32_t j = b / blocks_along_ * kBlockSide + c / kBlockSide;
      if (heaviest.next == kNone) {
        tile.points.push_back(pointOf(heaviest, i, j));
        continue;
      }
      column.assign(1, &heaviest);
      while (column.back()->next != kNone) column.push_back(&voxel(column.back()->next));
      std::sort(column.begin(), column.end(),
                [](const Voxel* p, const Voxel* q) { return p->height < q->height; });
      for (const Voxel* v : column) tile.points.push_back(pointOf(*v, i, j));
    }
  }
  return tile;
}

std::size_t VoxelTile::bytes() const {
  return slabs_.size() * sizeof(Slab) + filled_blocks_ * sizeof(Block) +
         blocks_.size() * sizeof(blocks_[0]);
}

}  // namespace cf
