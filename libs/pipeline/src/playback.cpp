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

namespace cf {
namespace {

/// Photos between playback and centre; of each its features and a small grey picture are kept.
constexpr std::size_t kPhotosInFlight = 16;

using Ready = std::shared_ptr<ReadyPhoto>;
using Step = std::shared_ptr<ChainStep>;

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

/// Real-time playback: waits until the photo's moment has come.
void keepPace(TimeNs since_first, double rate, double started_s) {
  if (rate <= 0) return;
  const double wait = started_s + seconds(since_first) / rate - wallSeconds();
  if (wait > 0) std::this_thread::sleep_for(std::chrono::duration<double>(wait));
}

}  // namespace

std::vector<std::vector<double>> playFlight(const std::vector<UavRecording>& recordings,
                                            std::deque<UavChain>& chains, double rate,
                                            CentralNode& centre) {
  std::vector<std::vector<double>> arrival_s;
  for (const UavRecording& r : recordings) arrival_s.emplace_back(r.photos.size());
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
    keepPace(timeOf(id) - timeOf(order.front()), rate, started);
    arrival_s[id.uav][id.index] = wallSeconds();
    return next++;
  };
  const auto prepare = [&](std::size_t i) { return chains[order[i].uav].prepare(order[i].index); };
  const auto push = [&](const Ready& photo) {
    return std::make_shared<ChainStep>(chains[photo->frame.id.uav].push(*photo));
  };
  const auto receive = [&](const Step& step) {
    centre.receive(std::move(*step));
    progress.advance();
  };
  constexpr auto kInOrder = tbb::filter_mode::serial_in_order;
  tbb::parallel_pipeline(kPhotosInFlight, tbb::make_filter<void, std::size_t>(kInOrder, takeUp) &
                                              tbb::make_filter<std::size_t, Ready>(
                                                  tbb::filter_mode::parallel, prepare) &
                                              tbb::make_filter<Ready, Step>(kInOrder, push) &
                                              tbb::make_filter<Step, void>(kInOrder, receive));
  for (UavChain& chain : chains) centre.receive(chain.finish());
  return arrival_s;
}

}  // namespace cf
