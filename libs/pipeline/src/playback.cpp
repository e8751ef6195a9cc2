// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "playback.h"

#include <tbb/parallel_pipeline.h>

#include <memory>
#include <utility>

#include "cf/base/progress.h"
#include "cf/base/stopwatch.h"

namespace cf {

TakenTimes playFlight(StepSource& source, const PlaybackOptions& options, CentralNode& centre,
                      LiveMap* live) {
  using Step = StepSource::Step;
  using Job = std::shared_ptr<LiveMap::Job>;
  using Depth = std::shared_ptr<LiveMap::Depth>;
  TakenTimes taken_s;
  for (const auto& of_uav : source.photos()) taken_s.emplace_back(of_uav.size());
  Progress progress("localise", source.photoCount());
  const auto receive = [&](const Step& step) {
    if (step->photo) {
      taken_s[step->photo->uav][step->photo->index] = step->taken_s;
      progress.advance();
    }
    const PoseTable* version = centre.receive(std::move(step->step));
    return std::make_shared<LiveMap::Job>(live && version ? live->jobOf(*version) : LiveMap::Job{});
  };
  const auto late = [&](FrameId id) {
    return options.rate > 0 && wallSeconds() - taken_s[id.uav][id.index] > options.max_lag_s;
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
  return taken_s;
}

}  // namespace cf
