// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "dense_mapping.h"

#include <tbb/parallel_invoke.h>
#include <tbb/parallel_pipeline.h>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

#include <algorithm>
#include <cmath>
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
#include "map_rasters.h"
#include "photo_decoder.h"

namespace cf {
namespace {

/// Photos in memory while pairs are matched; partners are mostly neighbours.
constexpr std::size_t kCachedPhotos = 12;
constexpr std::size_t kPhotosInFlight = 3;
constexpr int kPhotosPerRelease = 8;

std::vector<DenseView> denseViews(const Alignment& alignment) {
  std::vector<DenseView> views;
  for (const auto& [id, entry] : alignment.table.poses)
    if (entry.median_depth_m > 0)
      views.push_back({id, entry.T_world_cam, alignment.table.cameras[id.uav], entry.near_depth_m,
                       entry.median_depth_m, entry.far_depth_m});
  return views;
}

/// Ground size of a matched pixel, the median over the views.
double matchedGroundSize(const std::vector<DenseView>& views, double megapixels) {
  std::vector<double> sizes;
  for (const DenseView& v : views) {
    const double pixels = static_cast<double>(v.camera.width) * v.camera.height;
    const double reduction = std::max(1.0, std::sqrt(pixels / (megapixels * 1e6)));
    sizes.push_back(v.median_depth_m * reduction / v.camera.fx);
  }
  std::nth_element(sizes.begin(), sizes.begin() + static_cast<long>(sizes.size() / 2), sizes.end());
  return sizes[sizes.size() / 2];
}

/// Gives memory that is free, but kept for later, back to the system: images and points of changing
/// sizes leave holes that add up to hundreds of MB.
void releaseFreeMemory() {
#if defined(__GLIBC__)
  malloc_trim(0);
#endif
}

/// What one photo adds to the map.
struct Contribution {
  FrameId reference;
  struct Frame {
    FrameId partner;
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

class DenseMapper {
 public:
  DenseMapper(const std::vector<std::vector<ImageFrame>>& photos, const Alignment& alignment,
              const GridFrame& grid, const RunOptions& options, const std::filesystem::path& outdir,
              StageTimes& times)
      : photos_(photos),
        alignment_(alignment),
        grid_(grid),
        options_(options),
        outdir_(outdir),
        times_(times),
        views_(denseViews(alignment)),
        // Half the area is common to a pair: twice the pixels keep its resolution.
        cache_(2 * options.densify.megapixels, kCachedPhotos),
        depth_maps_(options.densify.megapixels) {}

  DenseSummary run() {
    if (views_.empty()) return summary_;
    const double matched_pixel_m = matchedGroundSize(views_, options_.densify.megapixels);
    const FuseOptions fuse = options_.fuse.resolved(matched_pixel_m);
    summary_.voxel_m = fuse.voxel_m;
    rasters_.emplace(options_.deliver, grid_, fuse.voxel_m);
    // Raw tiles live beside the result until the finished cloud has been made of them.
    auto map = std::make_unique<TileMap>(fuse, outdir_ / ".cf-run-tiles");
    matchAndFuse(*map);
    DirectoryTileStore cloud = deliver(*map, fuse);
    map.reset();
    rasters_->write(views_, photos_, cloud, matched_pixel_m, outdir_, times_);
    return summary_;
  }

 private:
  void matchAndFuse(TileMap& map) {
    choosePairs();
    Progress progress("densify", views_.size());
    std::size_t next = 0;
    int fused = 0;
    releaseFreeMemory();  // of localisation
    tbb::parallel_pipeline(
        kPhotosInFlight,
        tbb::make_filter<void, std::size_t>(tbb::filter_mode::serial_in_order,
                                            [&](tbb::flow_control& control) {
                                              if (next == views_.size()) control.stop();
                                              return next++;
                                            }) &
            tbb::make_filter<std::size_t, std::shared_ptr<Contribution>>(
                tbb::filter_mode::parallel,
                [&](std::size_t i) {
                  return std::make_shared<Contribution>(contribute(views_[i]));
                }) &
            tbb::make_filter<std::shared_ptr<Contribution>, void>(
                tbb::filter_mode::serial_in_order, [&](const std::shared_ptr<Contribution>& c) {
                  fuse(*c, map);
                  if (++fused % kPhotosPerRelease == 0) releaseFreeMemory();
                  progress.advance();
                }));
  }

  cv::Mat image(FrameId id) {
    const StageTimes::Scope scope(times_, "decode");
    return cache_.get(photos_[id.uav][id.index]);
  }

  const DenseView& view(FrameId id) const {
    return *std::lower_bound(views_.begin(), views_.end(), id,
                             [](const DenseView& v, FrameId wanted) { return v.id < wanted; });
  }

  /// Partners of every photo, in its component; a pair that two photos choose is matched once, from
  /// the first of them.
  void choosePairs() {
    const StageTimes::Scope scope(times_, "densify");
    for (const DenseView& reference : views_) {
      std::vector<DenseView> others;
      const int component = alignment_.table.poses.at(reference.id).component;
      for (const DenseView& v : views_)
        if (v.id != reference.id && alignment_.table.poses.at(v.id).component == component)
          others.push_back(v);
      std::vector<FrameId>& chosen = partners_[reference.id];
      for (const FrameId id : choosePartners(reference, others, options_.densify)) {
        const auto earlier = partners_.find(id);
        if (earlier == partners_.end() ||
            std::count(earlier->second.begin(), earlier->second.end(), reference.id) == 0)
          chosen.push_back(id);
      }
    }
  }

  Contribution contribute(const DenseView& reference) {
    Contribution out;
    out.reference = reference.id;
    if (rasters_->wantsPhotos()) {
      const cv::Mat photo = image(reference.id);
      const StageTimes::Scope scope(times_, "orthophoto");
      rasters_->add(reference.id, photo);
    }
    for (const FrameId id : partners_.at(reference.id)) {
      const cv::Mat reference_image = image(reference.id), partner_image = image(id);
      if (reference_image.empty() || partner_image.empty()) continue;
      const DenseView& partner = view(id);
      const StageTimes::Scope scope(times_, "densify");
      const auto depth =
          matchPair(reference, reference_image, partner, partner_image, options_.densify);
      if (!depth) {
        ++out.failures[depth.failure().code];
        continue;
      }
      DepthTriangulationOptions triangulation;
      triangulation.min_confidence = options_.densify.min_confidence;
      out.frames.push_back(
          {id, triangulateDepth(*depth, {reference.T_world_cam, reference.camera},
                                {partner.T_world_cam, partner.camera}, triangulation)});
    }
    return out;
  }

  void fuse(const Contribution& contribution, TileMap& map) {
    const StageTimes::Scope scope(times_, "fuse");
    for (const auto& frame : contribution.frames) {
      map.insert(contribution.reference, frame.points);
      ++summary_.depth_frames;
    }
    for (const auto& [code, count] : contribution.failures) summary_.failures[code] += count;
    if (options_.deliver.depth_maps) mapDepth(contribution);
    if (!contribution.frames.empty())
      rays_.emplace_back(contribution.reference,
                         sample(contribution.frames, options_.octomap.rays_per_keyframe));
    summary_.finished_s[contribution.reference] = wallSeconds();
  }

  /// A pair is matched from the first of its photos: when a photo's turn has come, its pairs with
  /// all earlier ones are there, and its map is complete.
  void mapDepth(const Contribution& contribution) {
    for (const auto& frame : contribution.frames) {
      depth_maps_.add(view(contribution.reference), frame.points);
      depth_maps_.add(view(frame.partner), frame.points);
    }
    const FrameId id = contribution.reference;
    const std::optional<FloatRaster> map = depth_maps_.take(id);
    if (!map) return;
    const std::filesystem::path folder = outdir_ / "depth" / options_.uavs[id.uav].name;
    std::filesystem::create_directories(folder);
    const std::filesystem::path photo = photos_[id.uav][id.index].name;
    writeFloatRaster(folder / (photo.stem().string() + ".tif"), *map);
  }

  /// The tiles of the finished cloud.
  DirectoryTileStore deliver(TileMap& map, const FuseOptions& fuse) {
    const StageTimes::Scope scope(times_, "deliver_cloud", CpuClock::kProcess);
    map.leaveMemory();
    OctoMapBuilder octomap(options_.octomap.resolved(fuse.voxel_m));
    DirectoryTileStore tiles =
        DirectoryTileStore::create(outdir_ / "cloud", fuse.tile_m, fuse.voxel_m);
    PlyWriter ply(outdir_ / "cloud" / "cloud.ply");
    std::optional<LasCloud> las;
    if (options_.deliver.las) las.emplace(outdir_ / "cloud" / "cloud.las", grid_);
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
          [&] { rasters_->add(tile); }, [&] { octomap.addSurface(tile); },
          [&] { tiles.save(tile); });
    });
    tiles.flush();
    ply.close();
    if (las) las->close();
    summary_.points = delivery.points;
    for (const auto& [id, points] : rays_)
      octomap.carve(alignment_.table.poses.at(id).T_world_cam.translation(), points);
    octomap.write(outdir_ / "octomap");
    return tiles;
  }

  const std::vector<std::vector<ImageFrame>>& photos_;
  const Alignment& alignment_;
  const GridFrame& grid_;
  const RunOptions& options_;
  const std::filesystem::path outdir_;
  StageTimes& times_;
  const std::vector<DenseView> views_;
  PhotoCache cache_;
  DepthMaps depth_maps_;
  std::map<FrameId, std::vector<FrameId>> partners_;
  std::vector<std::pair<FrameId, MapPoints>> rays_;
  std::optional<MapRasters> rasters_;
  DenseSummary summary_;
};

}  // namespace

DenseSummary mapDensely(const std::vector<std::vector<ImageFrame>>& photos,
                        const Alignment& alignment, const GridFrame& grid,
                        const RunOptions& options, const std::filesystem::path& outdir,
                        StageTimes& times) {
  return DenseMapper(photos, alignment, grid, options, outdir, times).run();
}

}  // namespace cf
