// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/fuse/voxel_tile_map.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>

#include "cf/base/error.h"
#include "voxel_index.h"
#include "voxel_tile.h"

namespace cf {
namespace {

constexpr double kTileIndexLimit = 1e8;
constexpr std::size_t kTilesAtOnce = 4;  ///< brought back side by side

}  // namespace

struct TileMap::Entry {
  std::unique_ptr<VoxelTile> voxels;  ///< null while it is in its file
  std::uint64_t used = 0;
  bool dirty = false;           ///< differs from its file
  std::size_t bytes_there = 0;  ///< that it takes in memory, when it is in its file
};

/// Consecutive points of one tile.
struct TileMap::Run {
  std::size_t begin, end;
};

TileMap::TileMap(const FuseOptions& options, std::filesystem::path scratch)
    : options_(options), scratch_(std::move(scratch)) {
  if (!(options_.voxel_m > 0) || options_.voxel_m > options_.tile_m ||
      options_.tile_m / options_.voxel_m > VoxelTile::kMaxColumns)
    throw UsageError(fmt::format(
        "[fuse] voxel_m = {} does not fit tile_m = {}: a tile must be 1 to {} voxels wide",
        options_.voxel_m, options_.tile_m, VoxelTile::kMaxColumns));
  std::error_code error;
  std::filesystem::remove_all(scratch_, error);
  if (!error) std::filesystem::create_directories(scratch_, error);
  if (error)
    throw RunError(fmt::format("{}: cannot be made anew: {}", scratch_.string(), error.message()));
}

TileMap::~TileMap() {
  std::error_code ignored;
  std::filesystem::remove_all(scratch_, ignored);
}

void TileMap::insert(FrameId depth_frame, const MapPoints& points) {
  if (view_ == 0 || depth_frame != view_frame_) ++view_;
  view_frame_ = depth_frame;

  // Tile by tile, so that a frame over many tiles does not drive them in and out of memory; and
  // those in memory first: were all taken in the order of their index, the ones that come in would
  // drive out the next ones, frame after frame.
  const Runs runs = runsByTile(points);
  std::vector<TileIndex> here, away;
  for (const auto& [index, list] : runs) (tiles_[index].voxels ? here : away).push_back(index);
  fill(here, runs, points);
  for (std::size_t begin = 0; begin < away.size(); begin += kTilesAtOnce) {
    const std::vector<TileIndex> some(
        away.begin() + static_cast<std::ptrdiff_t>(begin),
        away.begin() + static_cast<std::ptrdiff_t>(std::min(away.size(), begin + kTilesAtOnce)));
    std::size_t wanted = 0;
    for (const TileIndex index : some) wanted += tiles_[index].bytes_there;
    makeRoom(wanted);
    fill(some, runs, points);
  }
  makeRoom(0);
}

TileMap::Runs TileMap::runsByTile(const MapPoints& points) {
  const double tile_m = options_.tile_m;
  Runs runs;
  std::vector<Run>* list = nullptr;
  TileIndex current;
  double west = 0, east = 0, south = 0, north = 0;  // of the current tile
  for (std::size_t i = 0; i < points.points.size(); ++i) {
    const Eigen::Vector3f& p = points.points[i].position_m;
    const double x = points.origin_m.x() + static_cast<double>(p.x());
    const double y = points.origin_m.y() + static_cast<double>(p.y());
    if (!(x >= west && x < east && y >= south && y < north)) {
      if (!(std::abs(x / tile_m) < kTileIndexLimit && std::abs(y / tile_m) < kTileIndexLimit)) {
        ++stats_.dropped;
        list = nullptr;
        east = west;  // the next one looks again
        continue;
      }
      // Equation (10).
      current = {static_cast<std::int32_t>(floorToInt(x / tile_m)),
                 static_cast<std::int32_t>(floorToInt(y / tile_m))};
      west = current.x * tile_m;
      east = west + tile_m;
      south = current.y * tile_m;
      north = south + tile_m;
      list = &runs[current];
      list->push_back({i, i});
    }
    list->back().end = i + 1;
  }
  return runs;
}

void TileMap::fill(const std::vector<TileIndex>& tiles, const Runs& runs, const MapPoints& points) {
  std::vector<std::size_t> merged(tiles.size());
  std::vector<Entry*> entries;
  for (const TileIndex index : tiles) entries.push_back(&tiles_[index]);
  // A thread that waits here must not begin with another photo meanwhile.
  tbb::this_task_arena::isolate([&] {
    tbb::parallel_for(std::size_t{0}, tiles.size(), [&](std::size_t i) {
      Entry& entry = *entries[i];
      if (!entry.voxels) {
        entry.voxels = std::make_unique<VoxelTile>(tiles[i], options_.tile_m, options_.voxel_m);
        if (entry.bytes_there > 0) entry.voxels->load(file(tiles[i]));
      }
      for (const Run& run : runs.at(tiles[i]))
        merged[i] += entry.voxels->add(points.origin_m, points.points.data() + run.begin,
                                       points.points.data() + run.end, view_);
    });
  });
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    Entry& entry = *entries[i];
    if (entry.bytes_there > 0) ++stats_.reloaded;
    entry.bytes_there = 0;
    entry.used = ++clock_;
    entry.dirty = true;
    stats_.points += merged[i];
    for (const Run& run : runs.at(tiles[i])) stats_.dropped += run.end - run.begin;
    stats_.dropped -= merged[i];
  }
}

std::filesystem::path TileMap::file(TileIndex index) const {
  return scratch_ / fmt::format("{}_{}.voxels", index.x, index.y);
}

void TileMap::evict(TileIndex index, Entry& entry) {
  if (entry.dirty) {
    entry.voxels->save(file(index));
    ++stats_.saved;
  }
  entry.dirty = false;
  entry.bytes_there = entry.voxels->bytes();
  entry.voxels.reset();
}

void TileMap::makeRoom(std::size_t wanted_bytes) {
  const auto budget = static_cast<std::size_t>(options_.max_memory_mb) << 20;
  std::size_t held = bytes() + wanted_bytes;
  while (held > budget) {
    auto oldest = tiles_.end();
    std::size_t tiles = 0;
    for (auto it = tiles_.begin(); it != tiles_.end(); ++it) {
      if (!it->second.voxels) continue;
      ++tiles;
      if (oldest == tiles_.end() || it->second.used < oldest->second.used) oldest = it;
    }
    if (tiles == 0 || (tiles == 1 && wanted_bytes == 0)) return;
    evict(oldest->first, oldest->second);
    held -= oldest->second.bytes_there;
  }
}

std::vector<TileIndex> TileMap::indices() const {
  std::vector<TileIndex> result;
  for (const auto& [index, entry] : tiles_) result.push_back(index);
  return result;
}

Tile TileMap::tile(TileIndex index) const {
  const Entry& entry = tiles_.at(index);
  if (entry.voxels) return entry.voxels->toTile();
  VoxelTile voxels(index, options_.tile_m, options_.voxel_m);
  voxels.load(file(index));
  return voxels.toTile();
}

void TileMap::leaveMemory() {
  for (auto& [index, entry] : tiles_)
    if (entry.voxels) evict(index, entry);
}

std::size_t TileMap::bytes() const {
  std::size_t sum = 0;
  for (const auto& [index, entry] : tiles_)
    if (entry.voxels) sum += entry.voxels->bytes();
  return sum;
}

TileMap::Stats TileMap::stats() const {
  Stats stats = stats_;
  for (const auto& [index, entry] : tiles_) {
    if (!entry.voxels) continue;
    ++stats.resident_tiles;
    stats.resident_voxels += entry.voxels->size();
  }
  stats.resident_bytes = bytes();
  return stats;
}

}  // namespace cf
