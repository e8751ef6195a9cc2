// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "chain_steps.h"

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>
#include <variant>

namespace cf {
namespace {

SeamHello helloOf(const UavInput& input, const std::optional<LocalFrame>& world) {
  SeamHello hello;
  hello.uav = input.uav;
  hello.name = input.name;
  for (const ImageFrame& photo : input.recording.photos)
    hello.photos.push_back({photo.name, photo.time});
  if (!input.recording.photos.empty()) hello.camera = input.recording.photos.front().camera;
  hello.first_fix = firstFix(input.recording);
  if (hello.first_fix && world) {
    const Geodetic& origin = world->origin();
    hello.origin = {origin.latitude_deg, origin.longitude_deg, origin.height_m};
  }
  hello.warnings = input.recording.warnings;
  return hello;
}

/// Waits until the moment has come; how long ago it was, if it has passed.
double waitUntil(double moment_s) {
  const double wait = moment_s - wallSeconds();
  if (wait > 0) std::this_thread::sleep_for(std::chrono::duration<double>(wait));
  return std::max(0.0, -wait);
}

}  // namespace

ChainSteps::ChainSteps(std::vector<UavInput> inputs, const RunOptions& options,
                       const std::optional<LocalFrame>& world, StageTimes& times,
                       const std::filesystem::path& seam)
    : playback_(options.playback) {
  for (UavInput& input : inputs) {
    hellos_.push_back(helloOf(input, world));
    photos_.push_back(input.recording.photos);
    const auto file = seam.empty() ? seam : seam / (input.name + ".seam");
    uavs_.emplace_back(std::move(input), options, world, times, file);
    uavs_.back().writer.write(hellos_.back());
  }
  order_ = order();
}

tbb::filter<void, StepSource::Step> ChainSteps::steps() {
  constexpr auto kInOrder = tbb::filter_mode::serial_in_order;
  started_s_ = wallSeconds();
  return tbb::make_filter<void, Photo>(
             kInOrder, [this](tbb::flow_control& control) { return takeUp(control); }) &
         tbb::make_filter<Photo, Photo>(
             tbb::filter_mode::parallel,
             [this](const Photo& taken) {
               if (!isLast(taken->place))
                 taken->photo = uavs_[taken->place.uav].chain.prepare(taken->place.photo);
               return taken;
             }) &
         tbb::make_filter<Photo, Step>(kInOrder,
                                       [this](const Photo& taken) { return push(*taken); });
}

ChainSteps::Photo ChainSteps::takeUp(tbb::flow_control& control) {
  if (next_ == order_.size()) {
    control.stop();
    return nullptr;
  }
  auto taken = std::make_shared<Taken>();
  taken->place = order_[next_++];
  taken->taken_s = wallSeconds();
  if (playback_.rate <= 0 || isLast(taken->place)) return taken;
  const auto timeOf = [&](const Place& p) { return hellos_[p.uav].photos[p.photo].time; };
  taken->taken_s =
      started_s_ + seconds(timeOf(taken->place) - timeOf(order_.front())) / playback_.rate;
  most_behind_s_ = std::max(most_behind_s_, waitUntil(taken->taken_s));
  return taken;
}

StepSource::Step ChainSteps::push(const Taken& taken) {
  Uav& uav = uavs_[taken.place.uav];
  auto out = std::make_shared<SourceStep>();
  out->taken_s = taken.taken_s;
  if (taken.photo) out->photo = taken.photo->frame.id;
  SeamMessage message = taken.photo ? uav.chain.push(*taken.photo) : uav.chain.finish();
  uav.writer.write(message);
  out->step = std::move(std::get<ChainStep>(message));
  if (!taken.photo) {
    uav.done = uav.chain.done();
    uav.writer.write(uav.done);
  }
  return out;
}

std::vector<SeamDone> ChainSteps::done() {
  std::vector<SeamDone> all;
  for (Uav& uav : uavs_) all.push_back(std::move(uav.done));
  return all;
}

std::uint64_t ChainSteps::bytes() const {
  std::uint64_t sum = 0;
  for (const Uav& uav : uavs_) sum += uav.writer.bytes();
  return sum;
}

}  // namespace cf
