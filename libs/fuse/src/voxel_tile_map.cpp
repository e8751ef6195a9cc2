// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/fuse/voxel_tile_map.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "cf/base/error.h"
#include "voxel_tile.h"

namespace cf {
namespace {

constexpr double kTileIndexLimit = 1e8;
constexpr std::size_t kTilesAtOnce = 4;

bool usable(const MapPoint& point, double tile_m) {
  return std::isfinite(point.weight) && point.weight > 0 && std::isfinite(point.position_m.z()) &&
         std::abs(point.position_m.x() / tile_m) < kTileIndexLimit &&
         std::abs(point.position_m.y() / tile_m) < kTileIndexLimit;
}

}  // namespace

struct TileMap::Resident {
  std::unique_ptr<VoxelTile> voxels;
  std::uint64_t used = 0;
  bool dirty = false;
};

/// Consecutive points of one tile.
struct TileMap::Run {
  std::size_t begin, end;
};

TileMap::TileMap(const FuseOptions& options, TileStore& store) : options_(options), store_(store) {
  if (!(options_.voxel_m > 0) || options_.voxel_m > options_.tile_m ||
      options_.tile_m / options_.voxel_m >= static_cast<double>(CellKey::kLimit))
    throw UsageError(fmt::format(
        "[fuse] voxel_m = {} does not fit tile_m = {}: it must be above 0 and within {:.0e} of it",
        options_.voxel_m, options_.tile_m, 1.0 / CellKey::kLimit));
}

TileMap::~TileMap() = default;

void TileMap::insert(FrameId depth_frame, const std::vector<MapPoint>& points) {
  if (view_ == 0 || depth_frame != view_frame_) ++view_;
  view_frame_ = depth_frame;

  // Tile by tile, so that a frame over many tiles does not drive them in and out of memory.
  const double tile_m = options_.tile_m;
  std::map<TileIndex, std::vector<Run>> runs;
  std::vector<Run>* run_list = nullptr;
  TileIndex current;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const MapPoint& point = points[i];
    if (!usable(point, tile_m)) {
      ++stats_.dropped;
      continue;
    }
    // Equation (10).
    const TileIndex index{static_cast<std::int32_t>(floorToInt(point.position_m.x() / tile_m)),
                          static_cast<std::int32_t>(floorToInt(point.position_m.y() / tile_m))};
    if (!run_list || !(index == current)) {
      current = index;
      run_list = &runs[index];
    }
    if (!run_list->empty() && run_list->back().end == i)
      run_list->back().end = i + 1;
    else
      run_list->push_back({i, i + 1});
  }

  // Those in memory first: were all taken in the order of their index, the ones that come in would
  // drive out the next ones, frame after frame.
  std::vector<TileIndex> order;
  for (const auto& [index, list] : runs) {
    const auto held = tiles_.find(index);
    if (held == tiles_.end()) continue;
    held->second.used = ++clock_;
    order.push_back(index);
  }
  for (const auto& [index, list] : runs)
    if (tiles_.count(index) == 0) order.push_back(index);

  for (const TileIndex index : order) {
    const std::vector<Run>& list = runs.at(index);
    Resident& tile = resident(index);
    tile.used = ++clock_;
    tile.dirty = true;
    for (const Run& run : list) {
      const std::size_t merged =
          tile.voxels->add(points.data() + run.begin, points.data() + run.end, view_);
      stats_.points += merged;
      stats_.dropped += run.end - run.begin - merged;
    }
    shrink(index);
  }
}

TileMap::Resident& TileMap::resident(TileIndex index) {
  const auto found = tiles_.find(index);
  if (found != tiles_.end()) return found->second;
  Resident tile;
  tile.voxels = std::make_unique<VoxelTile>(index, options_.tile_m, options_.voxel_m);
  if (const auto stored = store_.load(index)) {
    tile.voxels->merge(*stored);
    ++stats_.reloaded;
  }
  return tiles_.emplace(index, std::move(tile)).first->second;
}

void TileMap::save(Resident& tile) {
  if (!tile.dirty) return;
  store_.save(tile.voxels->toTile());
  tile.dirty = false;
  ++stats_.saved;
}

void TileMap::shrink(TileIndex keep) {
  const auto budget = static_cast<std::size_t>(options_.max_memory_mb) << 20;
  std::size_t held = bytes();
  while (held > budget && tiles_.size() > 1) {
    auto oldest = tiles_.end();
    for (auto it = tiles_.begin(); it != tiles_.end(); ++it)
      if (!(it->first == keep) && (oldest == tiles_.end() || it->second.used < oldest->second.used))
        oldest = it;
    save(oldest->second);
    held -= oldest->second.voxels->bytes();
    tiles_.erase(oldest);
  }
}

void TileMap::flush() {
  std::vector<Resident*> changed;
  for (auto& [index, tile] : tiles_)
    if (tile.dirty) changed.push_back(&tile);
  // A few at a time are made ready side by side and then written in order.
  for (std::size_t begin = 0; begin < changed.size(); begin += kTilesAtOnce) {
    const std::size_t count = std::min(kTilesAtOnce, changed.size() - begin);
    std::vector<Tile> ready(count);
    tbb::parallel_for(std::size_t{0}, count,
                      [&](std::size_t i) { ready[i] = changed[begin + i]->voxels->toTile(); });
    for (std::size_t i = 0; i < count; ++i) {
      store_.save(ready[i]);
      changed[begin + i]->dirty = false;
      ++stats_.saved;
    }
  }
  store_.flush();
}

std::size_t TileMap::bytes() const {
  std::size_t sum = 0;
  for (const auto& [index, tile] : tiles_) sum += tile.voxels->bytes();
  return sum;
}

TileMap::Stats TileMap::stats() const {
  Stats stats = stats_;
  stats.resident_tiles = tiles_.size();
  for (const auto& [index, tile] : tiles_) stats.resident_voxels += tile.voxels->size();
  stats.resident_bytes = bytes();
  return stats;
}

}  // namespace cf
