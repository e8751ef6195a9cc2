// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "playback.h"

#include <tbb/parallel_pipeline.h>

#include <memory>
#include <utility>

#include "cf/base/stopwatch.h"
#include "flight_progress.h"

namespace cf {

namespace {

/// What is to be done for what is new in the map, and since when.
struct Change {
  LiveMap::Job job;
  double received_s = 0;
};

}  // namespace

void PhotoTimes::set(FrameId photo, const Times& times) {
  const std::lock_guard<std::mutex> lock(mutex_);
  times_[photo] = times;
}

PhotoTimes::Times PhotoTimes::of(FrameId photo) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return times_.at(photo);
}

void playFlight(StepSource& source, const PlaybackOptions& options, const MemoryPlan& memory,
                CentralNode& centre, LiveMap* live, std::vector<std::vector<ImageFrame>>& photos,
                PhotoTimes& times) {
  using Step = StepSource::Step;
  using Job = std::shared_ptr<Change>;
  using Depth = std::shared_ptr<LiveMap::Depth>;
  FlightProgress progress(source, options.inRealTime());
  const auto receive = [&](const Step& step) {
    if (step->photo) {
      const FrameId id = step->photo->id;
      if (photos[id.uav].empty()) centre.introduce(id.uav, step->photo->camera);
      photos[id.uav].push_back(*step->photo);
      times.set(id, {step->taken_s, wallSeconds()});
    }
    progress.advance(*step);
    centre.receive(std::move(step->step));
    auto job = live ? live->jobOf(centre.mapOfNow()) : LiveMap::Job{};
    return std::make_shared<Change>(Change{std::move(job), wallSeconds()});
  };
  const auto match = [&](const Job& change) {
    // That a photo had to wait for the first version of the map does not mean that we are behind.
    const auto late = [&](FrameId id) {
      const PhotoTimes::Times of = times.of(id);
      const double behind_s = of.received_s - of.taken_s + wallSeconds() - change->received_s;
      return options.inRealTime() && behind_s > options.max_lag_s;
    };
    return std::make_shared<LiveMap::Depth>(live ? live->match(std::move(change->job), late)
                                                 : LiveMap::Depth{});
  };
  const auto show = [&](const Depth& depth) {
    if (live) live->show(std::move(*depth));
  };
  constexpr auto kInOrder = tbb::filter_mode::serial_in_order;
  tbb::parallel_pipeline(memory.steps_in_flight,
                         source.steps() & tbb::make_filter<Step, Job>(kInOrder, receive) &
                             tbb::make_filter<Job, Depth>(tbb::filter_mode::parallel, match) &
                             tbb::make_filter<Depth, void>(kInOrder, show));
  if (live) live->finish();
}

}  // namespace cf
