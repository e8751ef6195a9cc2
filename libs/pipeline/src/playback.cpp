// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "playback.h"

#include <tbb/parallel_pipeline.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <thread>
#include <tuple>
#include <utility>

#include "cf/base/progress.h"
#include "cf/base/stopwatch.h"

namespace cf {
namespace {

/// Photos between playback and centre; of each its features and a small grey picture are kept.
constexpr std::size_t kPhotosInFlight = 16;

using Ready = std::shared_ptr<ReadyPhoto>;
using Step = std::shared_ptr<ChainStep>;
using Job = std::shared_ptr<LiveMap::Job>;
using Depth = std::shared_ptr<LiveMap::Depth>;

std::vector<FrameId> inTimeOrder(const std::vector<UavRecording>& recordings) {
  std::vector<std::pair<TimeNs, FrameId>> photos;
  for (std::size_t u = 0; u < recordings.size(); ++u)
    for (std::size_t i = 0; i < recordings[u].photos.size(); ++i)
      photos.push_back({recordings[u].photos[i].time,
                        {static_cast<std::uint16_t>(u), static_cast<std::uint32_t>(i)}});
  // Of one UAV always in its own order.
  std::stable_sort(photos.begin(), photos.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<FrameId> order;
  for (const auto& [time, id] : photos) order.push_back(id);
  return order;
}

/// Waits until the moment has come; how long ago it was, if it has passed.
double waitUntil(double moment_s) {
  const double wait = moment_s - wallSeconds();
  if (wait > 0) std::this_thread::sleep_for(std::chrono::duration<double>(wait));
  return std::max(0.0, -wait);
}

}  // namespace

Played playFlight(const std::vector<UavRecording>& recordings, std::deque<UavChain>& chains,
                  const PlaybackOptions& options, CentralNode& centre, LiveMap* live) {
  Played played;
  for (const UavRecording& r : recordings) played.taken_s.emplace_back(r.photos.size());
  const std::vector<FrameId> order = inTimeOrder(recordings);
  const auto timeOf = [&](FrameId id) { return recordings[id.uav].photos[id.index].time; };
  Progress progress("localise", order.size());
  const double started = wallSeconds();
  std::size_t next = 0;
  const auto takeUp = [&](tbb::flow_control& control) -> std::size_t {
    if (next == order.size()) {
      control.stop();
      return next;
    }
    const FrameId id = order[next];
    double& taken = played.taken_s[id.uav][id.index];
    taken = wallSeconds();
    if (options.rate > 0) {
      taken = started + seconds(timeOf(id) - timeOf(order.front())) / options.rate;
      played.most_behind_s = std::max(played.most_behind_s, waitUntil(taken));
    }
    return next++;
  };
  const auto prepare = [&](std::size_t i) { return chains[order[i].uav].prepare(order[i].index); };
  const auto push = [&](const Ready& photo) {
    progress.advance();
    return std::make_shared<ChainStep>(chains[photo->frame.id.uav].push(*photo));
  };
  const auto receive = [&](const Step& step) {
    const PoseTable* version = centre.receive(std::move(*step));
    return std::make_shared<LiveMap::Job>(live && version ? live->jobOf(*version) : LiveMap::Job{});
  };
  const auto late = [&](FrameId id) {
    return options.rate > 0 && wallSeconds() - played.taken_s[id.uav][id.index] > options.max_lag_s;
  };
  const auto match = [&](const Job& job) {
    return std::make_shared<LiveMap::Depth>(live ? live->match(std::move(*job), late)
                                                 : LiveMap::Depth{});
  };
  const auto show = [&](const Depth& depth) {
    if (live) live->show(std::move(*depth));
  };
  constexpr auto kInOrder = tbb::filter_mode::serial_in_order;
  constexpr auto kParallel = tbb::filter_mode::parallel;
  tbb::parallel_pipeline(kPhotosInFlight,
                         tbb::make_filter<void, std::size_t>(kInOrder, takeUp) &
                             tbb::make_filter<std::size_t, Ready>(kParallel, prepare) &
                             tbb::make_filter<Ready, Step>(kInOrder, push) &
                             tbb::make_filter<Step, Job>(kInOrder, receive) &
                             tbb::make_filter<Job, Depth>(kParallel, match) &
                             tbb::make_filter<Depth, void>(kInOrder, show));
  for (UavChain& chain : chains) show(match(receive(std::make_shared<ChainStep>(chain.finish()))));
  if (live) live->finish();
  return played;
}

}  // namespace cf
