// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <filesystem>

#include "cf/base/stopwatch.h"
#include "cf/formats/seam_file.h"
#include "step_source.h"
#include "uav_chain.h"
#include "uav_input.h"

namespace cf {

/// Plays recordings side by side at [playback] rate times real time (0: as fast as possible)
/// through their UAVs' chains. Photos are decoded and searched for features several at a time;
/// odometry takes them up in order.
class ChainSteps : public StepSource {
 public:
  /// What crosses the seam is written to <uav>.seam in the folder, or, without one, only counted.
  /// What is given by reference must outlive it.
  ChainSteps(std::vector<UavInput> inputs, const RunOptions& options,
             const std::optional<LocalFrame>& world, StageTimes& times,
             const std::filesystem::path& seam = {});

  tbb::filter<void, Step> steps() override;
  std::vector<SeamDone> done() override;
  std::uint64_t bytes() const override;

 private:
  /// A photo on its way through its chain.
  struct Taken {
    Place place;
    double taken_s = 0;
    std::shared_ptr<ReadyPhoto> photo;  ///< none at the UAV's end
  };
  using Photo = std::shared_ptr<Taken>;
  struct Uav {
    UavInput input;
    UavChain chain;
    SeamWriter writer;
    SeamDone done;
    Uav(UavInput from, const RunOptions& options, const std::optional<LocalFrame>& world,
        StageTimes& times, const std::filesystem::path& file)
        : input(std::move(from)),
          chain(input.recording, input.name, input.uav, world, options, times),
          writer(file) {}
  };
  Photo takeUp(tbb::flow_control& control);
  Step push(const Taken& taken);

  const PlaybackOptions& playback_;
  std::deque<Uav> uavs_;
  std::vector<Place> order_;
  std::size_t next_ = 0;
  double started_s_ = 0;
};

}  // namespace cf
