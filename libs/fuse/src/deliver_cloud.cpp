// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/fuse/deliver_cloud.h"

#include <tbb/parallel_pipeline.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "cf/fuse/cleaning.h"

namespace cf {
namespace {

constexpr std::size_t kTilesAtOnce = 4;  ///< on their way side by side

/// Tiles of a map; the longest unused make room.
class TileCache {
 public:
  TileCache(const TileMap& map, std::size_t budget_bytes) : map_(map), budget_bytes_(budget_bytes) {
    for (const TileIndex index : map.indices()) entries_[index];
  }

  /// Null where there is no such tile.
  std::shared_ptr<const Tile> get(TileIndex index) {
    const auto found = entries_.find(index);
    if (found == entries_.end()) return nullptr;
    Entry& entry = found->second;
    entry.used = ++clock_;
    if (!entry.tile) {
      entry.tile = std::make_shared<const Tile>(map_.tile(index));
      bytes_ += bytesOf(*entry.tile);
    }
    return entry.tile;
  }

  /// Drops what is in no neighbourhood any more, when the tiles from `next` on are left.
  void makeRoom(TileIndex next) {
    for (auto& [index, entry] : entries_)
      if (entry.tile && TileIndex{index.x + 1, index.y + 1} < next) drop(entry);
    while (bytes_ > budget_bytes_) {
      Entry* oldest = nullptr;
      for (auto& [index, entry] : entries_)
        if (entry.tile && (!oldest || entry.used < oldest->used)) oldest = &entry;
      drop(*oldest);
    }
  }

 private:
  struct Entry {
    std::shared_ptr<const Tile> tile;
    std::uint64_t used = 0;
  };
  static std::size_t bytesOf(const Tile& tile) { return tile.points.size() * sizeof(TilePoint); }
  void drop(Entry& entry) {
    bytes_ -= bytesOf(*entry.tile);
    entry.tile.reset();
  }

  const TileMap& map_;
  std::size_t budget_bytes_;
  std::size_t bytes_ = 0;
  std::uint64_t clock_ = 0;
  std::map<TileIndex, Entry> entries_;
};

/// One tile as delivered; counts what was left out.
Tile finished(const Tile& raw, const std::vector<const Tile*>& neighbours,
              const FuseOptions& options, Delivery& left_out) {
  Tile tile = cleaned(raw, neighbours, options.voxel_m, options.trusted_views);
  left_out.flying = raw.points.size() - tile.points.size();
  const std::size_t before = tile.points.size();
  const auto uncertain = [&](const TilePoint& point) {
    return point.views < options.min_views ||
           static_cast<double>(point.confidence) < options.min_confidence;
  };
  tile.points.erase(std::remove_if(tile.points.begin(), tile.points.end(), uncertain),
                    tile.points.end());
  left_out.uncertain = before - tile.points.size();
  return tile;
}

}  // namespace

Delivery deliverCloud(const TileMap& map, const FuseOptions& options,
                      const std::function<void(const Tile&)>& sink) {
  Delivery delivery;
  TileCache cache(map, static_cast<std::size_t>(options.max_memory_mb) << 20);
  const std::vector<TileIndex> indices = map.indices();
  struct Job {
    std::shared_ptr<const Tile> raw;
    std::vector<std::shared_ptr<const Tile>> neighbours;
    Tile clean;
    Delivery left_out;
  };
  using Item = std::shared_ptr<Job>;
  std::size_t next = 0;
  const auto take = [&](tbb::flow_control& control) -> Item {
    if (next == indices.size()) {
      control.stop();
      return nullptr;
    }
    const TileIndex index = indices[next++];
    auto job = std::make_shared<Job>();
    job->raw = cache.get(index);
    for (std::int32_t dx = -1; dx <= 1; ++dx)
      for (std::int32_t dy = -1; dy <= 1; ++dy) {
        if (dx == 0 && dy == 0) continue;
        if (auto tile = cache.get({index.x + dx, index.y + dy}))
          job->neighbours.push_back(std::move(tile));
      }
    if (next < indices.size()) cache.makeRoom(indices[next]);
    return job;
  };
  const auto clean = [&](const Item& job) {
    std::vector<const Tile*> neighbours;
    for (const auto& tile : job->neighbours) neighbours.push_back(tile.get());
    job->clean = finished(*job->raw, neighbours, options, job->left_out);
    job->raw.reset();
    job->neighbours.clear();
    return job;
  };
  const auto deliver = [&](const Item& job) {
    delivery.flying += job->left_out.flying;
    delivery.uncertain += job->left_out.uncertain;
    if (job->clean.points.empty()) return;
    ++delivery.tiles;
    delivery.points += job->clean.points.size();
    sink(job->clean);
  };
  constexpr auto kInOrder = tbb::filter_mode::serial_in_order;
  tbb::parallel_pipeline(kTilesAtOnce,
                         tbb::make_filter<void, Item>(kInOrder, take) &
                             tbb::make_filter<Item, Item>(tbb::filter_mode::parallel, clean) &
                             tbb::make_filter<Item, void>(kInOrder, deliver));
  return delivery;
}

}  // namespace cf
