// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "link_alignment.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <list>
#include <memory>
#include <optional>
#include <utility>

#include "cf/base/median.h"
#include "cf/features/patch_alignment.h"

namespace cf {
namespace {

constexpr double kMegapixels = 3;       ///< of the photos that patches are aligned in
constexpr double kMaxShift = 2;         ///< of a detection, at the feature size [px]
constexpr double kMostMagnified = 2.2;  ///< one sight against the other, in area
constexpr std::size_t kGreysInMemory = 64;
constexpr double kCellDepths = 0.5;  ///< side of the cells that links are aligned by, in depths

/// Grey values of the photos used last.
class Greys {
 public:
  explicit Greys(const PhotoSource& source) : source_(source) {}

  /// Has all of `wanted` ready.
  void load(const std::vector<FrameId>& wanted) {
    std::vector<FrameId> missing;
    for (const FrameId id : wanted) {
      const auto found = greys_.find(id);
      if (found == greys_.end())
        missing.push_back(id);
      else
        uses_.splice(uses_.begin(), uses_, found->second.use);
    }
    std::vector<cv::Mat> loaded(missing.size());
    tbb::parallel_for(std::size_t{0}, missing.size(), [&](std::size_t i) {
      const cv::Mat photo = source_(missing[i]);
      if (!photo.empty()) loaded[i] = greyForAlignment(photo, kMegapixels);
    });
    for (std::size_t i = 0; i < missing.size(); ++i) {
      uses_.push_front(missing[i]);
      greys_[missing[i]] = {std::move(loaded[i]), uses_.begin()};
    }
    while (greys_.size() > std::max(kGreysInMemory, wanted.size())) {
      greys_.erase(uses_.back());
      uses_.pop_back();
    }
  }

  const cv::Mat& operator[](FrameId id) const { return greys_.at(id).grey; }

 private:
  struct Entry {
    cv::Mat grey;
    std::list<FrameId>::iterator use;
  };
  const PhotoSource& source_;
  std::map<FrameId, Entry> greys_;
  std::list<FrameId> uses_;  ///< most recent first
};

/// Of a place on a curve that goes through all cells of a plane and seldom far (Morton 1966).
std::uint64_t alongCurve(double x, double y) {
  const auto spread = [](double v) {
    auto bits = static_cast<std::uint64_t>(
        static_cast<std::int64_t>(std::clamp(std::floor(v), -1e9, 1e9)) + (std::int64_t{1} << 30));
    std::uint64_t out = 0;
    for (int i = 0; i < 31; ++i) out |= (bits >> i & 1) << (2 * i);
    return out;
  };
  return spread(x) | spread(y) << 1;
}

/// Links by the cell of the map that they lie in, one cell beside the other: most of the photos
/// that see a cell saw the one before.
std::map<std::uint64_t, std::vector<std::size_t>> byCell(
    const std::vector<SparsePoint>& links, const std::map<FrameId, PosedPhoto>& photos) {
  std::vector<double> depths;
  for (const SparsePoint& link : links)
    depths.push_back(
        (photos.at(link.observations.front().frame).T_world_cam.inverse() * link.position_m).z());
  std::map<std::uint64_t, std::vector<std::size_t>> cells;
  const double cell_m = kCellDepths * upperMedian(std::move(depths));
  for (std::size_t i = 0; i < links.size(); ++i)
    cells[alongCurve(links[i].position_m.x() / cell_m, links[i].position_m.y() / cell_m)].push_back(
        i);
  return cells;
}

/// Derivative of the target's pixels by the source's.
Eigen::Matrix2d warpOf(const PosedPhoto& source, const PosedPhoto& target,
                       const Eigen::Vector3d& p_world) {
  return target.camera.fx / source.camera.fx *
         patchWarp(target.T_world_cam.inverse() * source.T_world_cam,
                   source.T_world_cam.inverse() * p_world);
}

/// One photo as patches are aligned in it.
struct View {
  const cv::Mat& grey;
  const PosedPhoto& posed;
  double grey_per_pixel;
};

class LinkAlignment {
 public:
  LinkAlignment(const MatchGraph& graph, const std::map<FrameId, PosedPhoto>& photos,
                const PhotoSource& source)
      : graph_(graph), photos_(photos), greys_(source) {}

  /// Where the sights of links lie, none where not aligned. Has all their photos in memory.
  using Positions = std::vector<std::optional<Eigen::Vector2d>>;
  std::vector<Positions> align(const std::vector<const SparsePoint*>& links) {
    std::vector<FrameId> wanted;
    for (const SparsePoint* link : links)
      for (const SparseObservation& o : link->observations) wanted.push_back(o.frame);
    std::sort(wanted.begin(), wanted.end());
    wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
    greys_.load(wanted);
    std::vector<Positions> positions(links.size());
    tbb::parallel_for(std::size_t{0}, links.size(),
                      [&](std::size_t i) { positions[i] = alignLink(*links[i]); });
    return positions;
  }

 private:
  View viewOf(FrameId id) const {
    const cv::Mat& grey = greys_[id];
    const PosedPhoto& posed = photos_.at(id);
    return {grey, posed, static_cast<double>(grey.cols) / posed.camera.width};
  }

  Eigen::Vector2d pixelOf(const SparseObservation& o) const {
    return graph_.photo(o.frame)
        .features->pixel[static_cast<std::size_t>(o.feature)]
        .cast<double>();
  }

  Positions alignLink(const SparsePoint& link) const {
    Positions positions(link.observations.size());
    const SparseObservation& first = link.observations.front();
    const View source = viewOf(first.frame);
    if (source.grey.empty()) return positions;
    positions[0] = pixelOf(first);
    const Eigen::Vector2d at = scaledPixel(*positions[0], source.grey_per_pixel);
    for (std::size_t i = 1; i < link.observations.size(); ++i) {
      const SparseObservation& o = link.observations[i];
      const View target = viewOf(o.frame);
      if (target.grey.empty()) continue;
      const Eigen::Matrix2d A = target.grey_per_pixel / source.grey_per_pixel *
                                warpOf(source.posed, target.posed, link.position_m);
      const double magnified = std::abs(A.determinant());
      if (!(magnified < kMostMagnified && magnified > 1 / kMostMagnified)) continue;
      const auto aligned = alignPatch(
          source.grey, at, target.grey, scaledPixel(pixelOf(o), target.grey_per_pixel), A,
          kMaxShift * graph_.photo(o.frame).features->pixel_size * target.grey_per_pixel);
      if (aligned) positions[i] = scaledPixel(aligned->position, 1 / target.grey_per_pixel);
    }
    return positions;
  }

  const MatchGraph& graph_;
  const std::map<FrameId, PosedPhoto>& photos_;
  Greys greys_;
};

}  // namespace

AlignedLinks alignLinks(const MatchGraph& graph, const std::vector<SparsePoint>& links,
                        const std::map<FrameId, PosedPhoto>& photos, const PhotoSource& source) {
  LinkAlignment alignment(graph, photos, source);
  AlignedLinks out;
  std::map<FrameId, FeatureSet> sights;
  for (const auto& [cell, numbers] : byCell(links, photos)) {
    std::vector<const SparsePoint*> of_cell;
    for (const std::size_t number : numbers) of_cell.push_back(&links[number]);
    const auto positions = alignment.align(of_cell);
    for (std::size_t i = 0; i < of_cell.size(); ++i) {
      const SparsePoint& link = *of_cell[i];
      if (std::count_if(positions[i].begin(), positions[i].end(),
                        [](const auto& p) { return p.has_value(); }) < 2) {
        out.left.push_back(link);
        continue;
      }
      Track& track = out.tracks.emplace_back();
      for (std::size_t k = 0; k < positions[i].size(); ++k) {
        if (!positions[i][k]) continue;
        const SparseObservation& o = link.observations[k];
        const FeatureSet& from = *graph.photo(o.frame).features;
        FeatureSet& to = sights[o.frame];
        const auto f = static_cast<std::size_t>(o.feature);
        track.push_back({o.frame, static_cast<int>(to.size())});
        to.pixel_size = from.pixel_size;
        to.pixel.push_back(positions[i][k]->cast<float>());
        to.scale_px.push_back(from.scale_px[f]);
        to.colour.insert(to.colour.end(), &from.colour[3 * f], &from.colour[3 * f] + 3);
      }
    }
  }
  for (auto& [id, features] : sights) {
    auto keyframe = std::make_shared<Keyframe>();
    keyframe->id = id;
    keyframe->camera = graph.photo(id).camera;
    keyframe->features = std::make_shared<const FeatureSet>(std::move(features));
    out.graph.add(std::move(keyframe));
  }
  return out;
}

}  // namespace cf
