// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "voxel_tile.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>

#include "cf/base/error.h"
#include "voxel_index.h"

namespace cf {
namespace {

constexpr float kPositionSteps = 65536;
constexpr float kLastStep = 65535.9F;
constexpr float kColourSteps = 257;

}  // namespace

VoxelTile::VoxelTile(TileIndex index, double tile_m, double voxel_m)
    : index_(index),
      offset_m_(index.x * tile_m, index.y * tile_m, 0),
      voxel_m_(voxel_m),
      columns_(std::max(1, static_cast<int>(std::ceil(tile_m / voxel_m)))),
      blocks_along_((columns_ + kBlockSide - 1) / kBlockSide),
      blocks_(static_cast<std::size_t>(blocks_along_) * static_cast<std::size_t>(blocks_along_)) {}

bool VoxelTile::locate(const Eigen::Vector3d& shift, const MapPoint& point, Arrival& arrival) {
  const double scale = 1 / voxel_m_;
  const double x = shift.x() + scale * static_cast<double>(point.position_m.x());
  const double y = shift.y() + scale * static_cast<double>(point.position_m.y());
  const double z = shift.z() + scale / kHeightOverSide * static_cast<double>(point.position_m.z());
  constexpr double kLimit = kZeroHeight - 1;
  if (!(std::abs(z) < kLimit) || !(point.weight > 0) ||
      !(point.weight <= std::numeric_limits<float>::max()))
    return false;
  // A point on the tile's edge may fall a rounding error outside of it.
  const int i = std::clamp(static_cast<int>(x), 0, columns_ - 1);
  const int j = std::clamp(static_cast<int>(y), 0, columns_ - 1);
  const auto k = static_cast<std::int32_t>(floorToInt(z));

  std::unique_ptr<Block>& block =
      blocks_[static_cast<std::size_t>(j / kBlockSide * blocks_along_ + i / kBlockSide)];
  if (!block) {
    block = std::make_unique<Block>();
    block->fill(kNone);
    ++filled_blocks_;
  }
  arrival.first = &(*block)[static_cast<std::size_t>(j % kBlockSide * kBlockSide + i % kBlockSide)];
  arrival.height = static_cast<std::uint32_t>(k + static_cast<std::int32_t>(kZeroHeight));
  arrival.weight = point.weight;
  const auto inside = [](double rest) {
    return std::clamp(kPositionSteps * static_cast<float>(rest), 0.F, kLastStep);
  };
  arrival.value[0] = inside(x - i);
  arrival.value[1] = inside(y - j);
  arrival.value[2] = inside(z - k);
  for (int c = 0; c < 3; ++c)
    arrival.value[3 + c] = kColourSteps * static_cast<float>(point.bgr[c]) + 0.5F;
  return true;
}

VoxelTile::Voxel* VoxelTile::voxelAt(const Arrival& arrival) {
  for (std::uint32_t number = *arrival.first; number != kNone;) {
    Voxel& found = voxel(number);
    if (found.height == arrival.height) return &found;
    number = found.next;
  }
  if (size_ == kNone) return nullptr;
  if (size_ % kSlabVoxels == 0) slabs_.push_back(std::make_unique<Slab>());
  Voxel& added = voxel(size_);
  added.height = arrival.height;
  added.next = *arrival.first;
  *arrival.first = size_++;
  return &added;
}

void VoxelTile::startView(std::uint32_t view) {
  if (stamp_ != 0 && view == view_) return;
  view_ = view;
  if (stamp_ == kMaxStamp) {  // from the beginning: what they stood for has passed
    for (std::uint32_t number = 0; number < size_; ++number) voxel(number).stamp = 0;
    stamp_ = 0;
  }
  ++stamp_;
}

std::size_t VoxelTile::add(const Eigen::Vector3d& origin_m, const MapPoint* begin,
                           const MapPoint* end, std::uint32_t view) {
  startView(view);
  const Eigen::Vector3d relative = (origin_m - offset_m_) / voxel_m_;
  const Eigen::Vector3d shift(relative.x(), relative.y(), relative.z() / kHeightOverSide);
  // In blocks, each memory access asked for ahead of its use: waiting for them is most of the time.
  constexpr std::size_t kAtOnce = 32;
  std::array<Arrival, kAtOnce> arrivals;
  std::size_t merged = 0;
  while (begin != end) {
    std::size_t n = 0;
    for (; begin != end && n < kAtOnce; ++begin) {
      if (!locate(shift, *begin, arrivals[n])) continue;
      __builtin_prefetch(arrivals[n].first, 1);
      ++n;
    }
    for (std::size_t i = 0; i < n; ++i)
      if (*arrivals[i].first != kNone) __builtin_prefetch(&voxel(*arrivals[i].first), 1);
    for (std::size_t i = 0; i < n; ++i) {
      const Arrival& arrival = arrivals[i];
      Voxel* const to = voxelAt(arrival);
      if (!to) continue;
      ++merged;
      to->weight += arrival.weight;
      const float share = arrival.weight / to->weight;
      for (int k = 0; k < kMeans; ++k) {
        const float mean = static_cast<float>(to->mean[k]) + 0.5F;
        to->mean[k] =
            static_cast<std::uint16_t>(static_cast<int>(mean + share * (arrival.value[k] - mean)));
      }
      if (to->stamp == stamp_) continue;
      to->stamp = stamp_;
      if (to->views < kMaxViews) ++to->views;
    }
  }
  return merged;
}

Tile VoxelTile::toTile() const {
  Tile tile;
  tile.index = index_;
  tile.offset_m = offset_m_;
  tile.points.reserve(size_);
  std::vector<const Voxel*> column;
  for (int j = 0; j < columns_; ++j) {
    for (int i = 0; i < columns_; ++i) {
      const Block* block =
          blocks_[static_cast<std::size_t>(j / kBlockSide * blocks_along_ + i / kBlockSide)].get();
      if (!block) {
        i |= kBlockSide - 1;
        continue;
      }
      column.clear();
      for (std::uint32_t number =
               (*block)[static_cast<std::size_t>(j % kBlockSide * kBlockSide + i % kBlockSide)];
           number != kNone; number = column.back()->next)
        column.push_back(&voxel(number));
      if (column.size() > 1)
        std::sort(column.begin(), column.end(),
                  [](const Voxel* a, const Voxel* b) { return a->height < b->height; });
      for (const Voxel* v : column) {
        const double cell[3] = {
            static_cast<double>(i), static_cast<double>(j),
            static_cast<double>(static_cast<std::int64_t>(v->height) - kZeroHeight)};
        TilePoint point;
        for (int k = 0; k < 3; ++k) {
          const double side = k < 2 ? voxel_m_ : kHeightOverSide * voxel_m_;
          point.position_m[k] =
              static_cast<float>(side * (cell[k] + (v->mean[k] + 0.5) / kPositionSteps));
          point.bgr[k] = static_cast<std::uint8_t>((v->mean[3 + k] + 128) / 257);
        }
        point.views = static_cast<std::uint16_t>(v->views);
        point.confidence = v->weight;
        tile.points.push_back(point);
      }
    }
  }
  return tile;
}

std::size_t VoxelTile::bytes() const {
  return slabs_.size() * sizeof(Slab) + filled_blocks_ * sizeof(Block) +
         blocks_.size() * sizeof(blocks_[0]);
}

}  // namespace cf
