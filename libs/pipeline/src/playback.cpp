// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "playback.h"

#include <tbb/parallel_pipeline.h>

#include <memory>
#include <utility>

#include "cf/base/stopwatch.h"
#include "flight_progress.h"

namespace cf {

void TakenTimes::set(FrameId photo, double wall_s) {
  const std::lock_guard<std::mutex> lock(mutex_);
  wall_s_[photo] = wall_s;
}

double TakenTimes::of(FrameId photo) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return wall_s_.at(photo);
}

void playFlight(StepSource& source, const PlaybackOptions& options, CentralNode& centre,
                LiveMap* live, std::vector<std::vector<ImageFrame>>& photos, TakenTimes& taken) {
  using Step = StepSource::Step;
  using Job = std::shared_ptr<LiveMap::Job>;
  using Depth = std::shared_ptr<LiveMap::Depth>;
  FlightProgress progress(source, options.inRealTime());
  const auto receive = [&](const Step& step) {
    if (step->photo) {
      const FrameId id = step->photo->id;
      if (photos[id.uav].empty()) centre.introduce(id.uav, step->photo->camera);
      photos[id.uav].push_back(*step->photo);
      taken.set(id, step->taken_s);
    }
    progress.advance(*step);
    const PoseTable* version = centre.receive(std::move(step->step));
    return std::make_shared<LiveMap::Job>(live && version ? live->jobOf(*version) : LiveMap::Job{});
  };
  const auto late = [&](FrameId id) {
    return options.inRealTime() && wallSeconds() - taken.of(id) > options.max_lag_s;
  };
  const auto match = [&](const Job& job) {
    return std::make_shared<LiveMap::Depth>(live ? live->match(std::move(*job), late)
                                                 : LiveMap::Depth{});
  };
  const auto show = [&](const Depth& depth) {
    if (live) live->show(std::move(*depth));
  };
  constexpr auto kInOrder = tbb::filter_mode::serial_in_order;
  tbb::parallel_pipeline(kStepsInFlight,
                         source.steps() & tbb::make_filter<Step, Job>(kInOrder, receive) &
                             tbb::make_filter<Job, Depth>(tbb::filter_mode::parallel, match) &
                             tbb::make_filter<Depth, void>(kInOrder, show));
  if (live) live->finish();
}

}  // namespace cf
