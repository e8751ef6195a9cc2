// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <utility>

#include "cf/base/stopwatch.h"
#include "cf/formats/seam_file.h"
#include "memory_gate.h"
#include "pacer.h"
#include "photo_feed.h"
#include "step_source.h"
#include "uav_chain.h"

namespace cf {

/// Plays recordings side by side through their UAVs' chains: at [playback] rate times real time (0:
/// as fast as possible), or, followed, as they come. Photos are decoded and searched for features
/// several at a time; odometry takes them up in order.
class ChainSteps : public StepSource {
 public:
  /// What crosses the seam is only counted. What is given by reference must outlive it.
  ChainSteps(PhotoFeed feed, const RunOptions& options, const std::optional<LocalFrame>& world,
             StageTimes& times);

  /// Before steps(): what one of the UAVs hands over the seam is written.
  void writeTo(std::size_t input, SeamWriter writer) { uavs_[input].writer = std::move(writer); }

  std::size_t photoCount() const override { return feed_.photosKnown(); }
  bool follows() const override { return feed_.follows(); }
  tbb::filter<void, Step> steps() override;
  std::vector<SeamDone> done() override;
  std::uint64_t bytes() const override;

 private:
  /// A photo on its way through its chain.
  struct Taken {
    PhotoFeed::Item item;
    double taken_s = 0;
    TimeNs next_from = 0;
    std::shared_ptr<ReadyPhoto> photo;  ///< none at the UAV's end
  };
  using Photo = std::shared_ptr<Taken>;
  struct Uav {
    UavChain chain;
    SeamWriter writer;
    SeamDone done;
    bool greeted = false;
    Uav(const UavInput& input, const RunOptions& options, const std::optional<LocalFrame>& world,
        StageTimes& times)
        : chain(input.name(), input.uav(), world, options, times) {}
  };
  Photo takeUp(tbb::flow_control& control);
  void greet(const PhotoFeed::Item& item);
  Step push(const Taken& taken);
  ChainStep finish(std::size_t input, const std::vector<GnssFix>& fixes);

  PhotoFeed feed_;
  const std::optional<LocalFrame>& world_;
  Pacer pacer_;
  MemoryGate gate_;
  std::deque<Uav> uavs_;
};

}  // namespace cf
