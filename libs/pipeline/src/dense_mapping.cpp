// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "dense_mapping.h"

#include <tbb/parallel_invoke.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>
#include <optional>

#include "cf/base/error.h"
#include "cf/base/progress.h"
#include "cf/deliver/las_cloud.h"
#include "cf/formats/float_raster.h"
#include "cf/formats/ply.h"
#include "cf/formats/tile_store.h"
#include "cf/fuse/deliver_cloud.h"
#include "cf/fuse/voxel_tile_map.h"
#include "cf/geometry/depth_triangulation.h"
#include "depth_maps.h"
#include "free_memory.h"
#include "map_rasters.h"
#include "memory_gate.h"

namespace cf {
namespace {

constexpr int kPhotosPerRelease = 8;

using Pairs = std::vector<StereoPair>;

/// What one photo adds to the map.
struct Contribution {
  FrameId reference;
  struct Frame {
    const StereoPair* pair;
    MapPoints points;
  };
  std::vector<Frame> frames;
  std::map<std::string, int> failures;
};

/// An even sample of points, for the rays that carve free space.
MapPoints sample(const std::vector<Contribution::Frame>& frames, int wanted) {
  std::size_t total = 0;
  for (const auto& frame : frames) total += frame.points.points.size();
  const std::size_t step =
      std::max<std::size_t>(1, total / static_cast<std::size_t>(std::max(1, wanted)));
  MapPoints out;
  out.origin_m = frames.front().points.origin_m;  // the photo's centre, of all its frames
  std::size_t i = 0;
  for (const auto& frame : frames)
    for (const MapPoint& p : frame.points.points)
      if (i++ % step == 0) out.points.push_back(p);
  return out;
}

/// `other` with the workers, `own` in this thread, or, if not at once, before; returns when both
/// are done. Throws what one of them threw, `own` first.
template <class Other, class Own>
void sideBySide(bool at_once, const Other& other, const Own& own) {
  if (!at_once) {
    own();
    releaseFreeMemory();
    return other();
  }
  tbb::task_group group;
  group.run(other);
  std::exception_ptr error;
  try {
    own();
  } catch (...) {
    error = std::current_exception();
    group.cancel();
  }
  try {
    group.wait();
  } catch (...) {
    if (!error) throw;
  }
  if (error) std::rethrow_exception(error);
}

class DenseMapper {
 public:
  DenseMapper(const std::vector<std::vector<ImageFrame>>& photos, const Alignment& alignment,
              const GridFrame& grid, const RunOptions& options, const MemoryPlan& memory,
              const WorkFolders& folders, DenseMatching& matching, PhotoStore& store,
              StageTimes& times)
      : photos_(photos),
        grid_(grid),
        options_(options),
        memory_(memory),
        folders_(folders),
        matching_(matching),
        store_(store),
        times_(times),
        views_(denseViews(alignment.table)),
        depth_maps_(options.densify.megapixels) {}

  void run(const std::function<void(const DenseSummary&)>& beside) {
    if (views_.empty()) return beside(summary_);
    const double matched_pixel_m = matchedGroundSize(views_, options_.densify.megapixels);
    FuseOptions fuse = options_.fuse.resolved(matched_pixel_m);
    fuse.max_memory_mb = memory_.tile_mb;
    summary_.voxel_m = fuse.voxel_m;
    rasters_.emplace(options_.deliver, grid_, fuse.voxel_m);
    // Raw tiles live beside the result until the finished cloud has been made of them.
    auto map = std::make_unique<TileMap>(fuse, folders_.work / "tiles");
    matchAndFuse(*map);
    DirectoryTileStore cloud = deliver(*map, fuse);
    map.reset();
    store_.leaveMemory();
    releaseFreeMemory();  // of the map and its products, before the rasters
    // What is drawn with one thread goes with what is left of the others.
    sideBySide(
        memory_.side_by_side, [&] { rasters_->writeDsm(cloud, folders_.outdir, times_); },
        [&] { writeOctomap(); });
    releaseFreeMemory();  // the pictures take some, and the orthophoto
    sideBySide(
        memory_.side_by_side,
        [&] {
          rasters_->writeOrthophoto(views_, photos_, store_, matched_pixel_m, memory_.crops_mb,
                                    folders_.outdir, times_);
        },
        [&] { beside(summary_); });
  }

 private:
  void matchAndFuse(TileMap& map) {
    planPairs();
    Progress progress("fuse", pairs_.size());
    auto next = pairs_.begin();
    int fused = 0;
    releaseFreeMemory();  // of localisation
    MemoryGate gate(memory_.limit_mb);
    using Item = std::shared_ptr<Contribution>;
    tbb::parallel_pipeline(
        memory_.photos_matched,
        tbb::make_filter<void, Pairs*>(tbb::filter_mode::serial_in_order,
                                       [&](tbb::flow_control& control) -> Pairs* {
                                         if (next == pairs_.end()) {
                                           control.stop();
                                           return nullptr;
                                         }
                                         gate.enter();
                                         return &(next++)->second;
                                       }) &
            tbb::make_filter<Pairs*, Item>(
                tbb::filter_mode::parallel,
                [&](Pairs* pairs) { return std::make_shared<Contribution>(contribute(*pairs)); }) &
            tbb::make_filter<Item, void>(tbb::filter_mode::serial_in_order, [&](const Item& c) {
              fuse(*c, map);
              if (++fused % kPhotosPerRelease == 0) releaseFreeMemory();
              progress.advance();
              gate.leave();
            }));
  }

  /// By reference, UAV by UAV: photos that follow each other see much of the same ground.
  void planPairs() {
    const StageTimes::Scope scope(times_, "densify");
    for (StereoPair& pair : stereoPairs(views_, options_.densify)) {
      ++unmapped_[pair.reference.id];
      ++unmapped_[pair.partner.id];
      pairs_[pair.reference.id].push_back(std::move(pair));
    }
  }

  Contribution contribute(const Pairs& pairs) {
    Contribution out;
    out.reference = pairs.front().reference.id;
    for (const StereoPair& pair : pairs) {
      out.frames.push_back({&pair, {}});
      const auto depth = matching_.frame(pair);
      if (!depth) {
        ++out.failures[depth.failure().code];
        continue;
      }
      const StageTimes::Scope scope(times_, "fuse");
      DepthTriangulationOptions triangulation;
      triangulation.min_confidence = options_.densify.min_confidence;
      out.frames.back().points =
          triangulateDepth(*depth, {pair.reference.T_world_cam, pair.reference.camera},
                           {pair.partner.T_world_cam, pair.partner.camera}, triangulation);
    }
    return out;
  }

  void fuse(const Contribution& contribution, TileMap& map) {
    const StageTimes::Scope scope(times_, "fuse");
    for (const auto& frame : contribution.frames) {
      if (options_.deliver.depth_maps) mapDepth(*frame.pair, frame.points);
      if (frame.points.points.empty()) continue;
      map.insert(contribution.reference, frame.points);
      ++summary_.depth_frames;
      for (const FrameId id : {frame.pair->reference.id, frame.pair->partner.id})
        summary_.finished_s.emplace(id, wallSeconds());
    }
    for (const auto& [code, count] : contribution.failures) summary_.failures[code] += count;
    rays_.emplace_back(contribution.frames.front().pair->reference.T_world_cam.translation(),
                       sample(contribution.frames, options_.octomap.rays_per_keyframe));
  }

  /// A photo's map is complete when all the pairs that it is in have come.
  void mapDepth(const StereoPair& pair, const MapPoints& points) {
    for (const DenseView* view : {&pair.reference, &pair.partner}) {
      depth_maps_.add(*view, points);
      if (--unmapped_.at(view->id) > 0) continue;
      const std::optional<FloatRaster> map = depth_maps_.take(view->id);
      if (!map) continue;
      const std::filesystem::path folder =
          folders_.outdir / "depth" / options_.uavs[view->id.uav].name;
      std::filesystem::create_directories(folder);
      const std::filesystem::path photo = photos_[view->id.uav][view->id.index].name;
      writeFloatRaster(folder / (photo.stem().string() + ".tif"), *map);
    }
  }

  /// The tiles of the finished cloud.
  DirectoryTileStore deliver(TileMap& map, const FuseOptions& fuse) {
    const StageTimes::Scope scope(times_, "deliver_cloud", CpuClock::kProcess);
    map.leaveMemory();
    const double area_m2 = static_cast<double>(map.indices().size()) * fuse.tile_m * fuse.tile_m;
    octomap_.emplace(options_.octomap.resolved(fuse.voxel_m, area_m2));
    DirectoryTileStore tiles =
        DirectoryTileStore::create(folders_.outdir / "cloud", fuse.tile_m, fuse.voxel_m);
    PlyWriter ply(folders_.outdir / "cloud" / "cloud.ply");
    std::optional<LasCloud> las;
    if (options_.deliver.las) las.emplace(folders_.outdir / "cloud" / "cloud.las", grid_);
    const Delivery delivery = deliverCloud(map, fuse, [&](const Tile& tile) {
      tbb::parallel_invoke(
          [&] {
            for (const TilePoint& p : tile.points) {
              const Eigen::Vector3d world = tile.offset_m + p.position_m.cast<double>();
              ply.add(world.cast<float>(), {p.bgr[2], p.bgr[1], p.bgr[0]});
            }
          },
          [&] {
            if (las) las->add(tile);
          },
          [&] { rasters_->add(tile); }, [&] { octomap_->addSurface(tile); },
          [&] { tiles.save(tile); }, [&] { summary_.cloud.add(tile); });
    });
    tiles.flush();
    ply.close();
    if (las) las->close();
    summary_.points = delivery.points;
    return tiles;
  }

  void writeOctomap() {
    const StageTimes::Scope scope(times_, "octomap");
    for (const auto& [centre, points] : rays_) octomap_->carve(centre, points);
    octomap_->write(folders_.outdir / "octomap");
    octomap_.reset();
  }

  const std::vector<std::vector<ImageFrame>>& photos_;
  const GridFrame& grid_;
  const RunOptions& options_;
  const MemoryPlan& memory_;
  const WorkFolders& folders_;
  DenseMatching& matching_;
  PhotoStore& store_;
  StageTimes& times_;
  const std::vector<DenseView> views_;
  DepthMaps depth_maps_;
  std::map<FrameId, Pairs> pairs_;   ///< by reference
  std::map<FrameId, int> unmapped_;  ///< pairs of a photo that its depth map waits for
  std::vector<std::pair<Eigen::Vector3d, MapPoints>> rays_;  ///< from camera centres
  std::optional<MapRasters> rasters_;
  std::optional<OctoMapBuilder> octomap_;
  DenseSummary summary_;
};

}  // namespace

void mapDensely(const std::vector<std::vector<ImageFrame>>& photos, const Alignment& alignment,
                const GridFrame& grid, const RunOptions& options, const MemoryPlan& memory,
                const WorkFolders& folders, DenseMatching& matching, PhotoStore& store,
                StageTimes& times, const std::function<void(const DenseSummary&)>& beside) {
  DenseMapper(photos, alignment, grid, options, memory, folders, matching, store, times)
      .run(beside);
}

}  // namespace cf
