// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "cf/base/stopwatch.h"
#include "cf/fuse/voxel_tile_map.h"
#include "cf/pipeline/run_options.h"
#include "cf/types/image_frame.h"
#include "cf/types/pose_table.h"
#include "photo_store.h"
#include "stereo_pairs.h"

namespace cf {

/// What is to be seen of the map while the UAVs fly: each photo is matched, small, with one taken
/// before it as soon as the common map holds both, and fused with the poses of that moment. The
/// map that a run delivers is made anew with the final poses and has nothing of this.
class LiveMap {
 public:
  /// What is to be done when the map has changed.
  struct Job {
    std::vector<StereoPair> pairs;  ///< of the photos that were not in it before
    std::vector<DenseView> views;   ///< of all, in the order in which they were taken
  };
  /// A job done.
  struct Depth {
    struct Frame {
      FrameId photo, partner;
      MapPoints points;
    };
    std::vector<Frame> frames;
    std::vector<FrameId> left_out;
    std::vector<DenseView> views;
  };

  /// What is given by reference must outlive it. `photos` by UAV; pictures go to `pictures`.
  LiveMap(const RunOptions& options, std::uint16_t central_uav,
          const std::vector<std::vector<ImageFrame>>& photos, std::filesystem::path scratch,
          std::filesystem::path pictures, const PhotoStore& store, StageTimes& times);

  /// In the order of the map's changes.
  Job jobOf(const PoseTable& table);
  /// Thread-safe. Photos that are `late` are not matched: the map must keep up.
  Depth match(Job job, const std::function<bool(FrameId)>& late) const;
  /// In the same order: fuses them, and draws when it is time to.
  void show(Depth depth);
  /// The last pictures.
  void finish();

  /// Wall time from which on something of a photo was in the live map.
  const std::map<FrameId, double>& shown() const { return shown_s_; }
  std::size_t leftOut() const { return left_out_; }

 private:
  void draw();

  const RunOptions& options_;
  const std::uint16_t central_uav_;
  const std::vector<std::vector<ImageFrame>>& photos_;
  const std::filesystem::path scratch_, pictures_;
  const PhotoStore& store_;
  StageTimes& times_;
  DensifyOptions densify_;
  std::set<FrameId> known_;
  std::vector<DenseView> views_;
  std::unique_ptr<TileMap> tiles_;
  double voxel_m_ = 0;
  double drawn_s_;
  std::map<FrameId, double> shown_s_;
  std::size_t left_out_ = 0;
};

}  // namespace cf
