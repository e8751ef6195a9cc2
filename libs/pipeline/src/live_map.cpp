// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "live_map.h"

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "cf/base/error.h"
#include "cf/formats/atomic_file.h"
#include "cf/geometry/depth_triangulation.h"
#include "live_picture.h"

namespace cf {
namespace {

constexpr int kTileMemory_mb = 100;

void writePng(const std::filesystem::path& path, const cv::Mat& picture) {
  if (picture.empty()) return;
  std::vector<uchar> bytes;
  cv::imencode(".png", picture, bytes);
  writeFileAtomically(path, std::string(bytes.begin(), bytes.end()));
}

}  // namespace

LiveMap::LiveMap(const RunOptions& options, std::uint16_t central_uav,
                 const std::vector<std::vector<ImageFrame>>& photos, std::filesystem::path scratch,
                 std::filesystem::path pictures, const PhotoStore& store, StageTimes& times)
    : options_(options),
      central_uav_(central_uav),
      photos_(photos),
      scratch_(std::move(scratch)),
      pictures_(std::move(pictures)),
      store_(store),
      times_(times),
      densify_(options.densify),
      drawn_s_(wallSeconds()) {
  densify_.megapixels = std::min(options.densify.megapixels, options.view.live_megapixels);
  densify_.partners = 1;
  std::error_code error;
  std::filesystem::create_directories(pictures_, error);
  if (error) throw RunError(pictures_.string() + " cannot be made: " + error.message());
}

LiveMap::Job LiveMap::jobOf(const PoseTable& table) {
  Job job;
  job.views = denseViews(table);
  const auto taken = [&](const DenseView& v) { return photos_[v.id.uav][v.id.index].time; };
  std::stable_sort(job.views.begin(), job.views.end(),
                   [&](const auto& a, const auto& b) { return taken(a) < taken(b); });
  std::map<FrameId, const DenseView*> by_id;
  std::vector<DenseView> earlier;
  for (const DenseView& view : job.views) {
    by_id[view.id] = &view;
    if (known_.insert(view.id).second)
      for (const FrameId id : choosePartners(view, earlier, densify_))
        job.pairs.push_back({view, *by_id.at(id)});
    earlier.push_back(view);
  }
  return job;
}

LiveMap::Depth LiveMap::match(Job job, const std::function<bool(FrameId)>& late) const {
  Depth depth;
  depth.views = std::move(job.views);
  for (const auto& [reference, partner] : job.pairs) {
    if (late(reference.id)) {
      depth.left_out.push_back(reference.id);
      continue;
    }
    const StageTimes::Scope scope(times_, "live");
    const cv::Mat a = store_.half(reference.id), b = store_.half(partner.id);
    if (a.empty() || b.empty()) continue;
    const auto frame = matchPair(reference, a, partner, b, densify_);
    if (!frame) continue;
    DepthTriangulationOptions triangulation;
    triangulation.min_confidence = densify_.min_confidence;
    depth.frames.push_back(
        {reference.id, partner.id,
         triangulateDepth(*frame, {reference.T_world_cam, reference.camera},
                          {partner.T_world_cam, partner.camera}, triangulation)});
  }
  return depth;
}

void LiveMap::show(Depth depth) {
  const StageTimes::Scope scope(times_, "live");
  if (!depth.views.empty()) views_ = std::move(depth.views);
  if (!tiles_ && !views_.empty()) {
    FuseOptions fuse;
    fuse.max_memory_mb = kTileMemory_mb;
    voxel_m_ = matchedGroundSize(views_, densify_.megapixels);
    tiles_ = std::make_unique<TileMap>(fuse.resolved(voxel_m_), scratch_);
  }
  for (const auto& [photo, partner, points] : depth.frames) {
    tiles_->insert(photo, points);
    for (const FrameId id : {photo, partner}) shown_s_.emplace(id, wallSeconds());
  }
  left_out_ += depth.left_out.size();
  const double every = options_.view.live_every_s;
  if (every > 0 && wallSeconds() - drawn_s_ >= every) draw();
}

void LiveMap::finish() {
  const StageTimes::Scope scope(times_, "live");
  if (options_.view.live_every_s > 0) draw();
  tiles_.reset();
}

void LiveMap::draw() {
  if (!tiles_) return;
  std::vector<Tile> tiles;
  for (const TileIndex index : tiles_->indices()) tiles.push_back(tiles_->tile(index));
  writePng(pictures_ / "map.png", liveMapPicture(tiles, voxel_m_, views_, central_uav_));
  writePng(pictures_ / "coverage.png", coveragePicture(views_, central_uav_));
  drawn_s_ = wallSeconds();
}

}  // namespace cf
