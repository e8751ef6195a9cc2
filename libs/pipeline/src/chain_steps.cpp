// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "chain_steps.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "cf/base/log.h"
#include "memory_plan.h"

namespace cf {
namespace {

constexpr TimeNs kNever = std::numeric_limits<TimeNs>::max();

/// Of the photos that wait to be taken up.
TimeNs nextOf(const UavInput& input) {
  return input.photos().empty() ? kNever : input.photos().front().photo.time;
}

/// As far as it is known.
SeamHello helloOf(const UavInput& input, const std::optional<LocalFrame>& world) {
  SeamHello hello;
  hello.uav = input.uav();
  hello.name = input.name();
  hello.first_fix = input.firstFix();
  if (input.isClosed()) hello.photos = input.photos().size();
  hello.next_from = nextOf(input);
  if (!hello.first_fix || !world) return hello;
  const Geodetic& origin = world->origin();
  hello.origin = {origin.latitude_deg, origin.longitude_deg, origin.height_m};
  return hello;
}

}  // namespace

ChainSteps::ChainSteps(PhotoFeed feed, const RunOptions& options,
                       const std::optional<LocalFrame>& world, StageTimes& times)
    : feed_(std::move(feed)), world_(world), pacer_(options.playback), gate_(memoryLimit(options)) {
  for (const UavInput& input : feed_.inputs()) {
    uavs_.emplace_back(input, options, world, times);
    hellos_.push_back(helloOf(input, world));
    hellos_.back().warnings = input.warnings();
  }
}

tbb::filter<void, StepSource::Step> ChainSteps::steps() {
  constexpr auto kInOrder = tbb::filter_mode::serial_in_order;
  return tbb::make_filter<void, Photo>(
             kInOrder, [this](tbb::flow_control& control) { return takeUp(control); }) &
         tbb::make_filter<Photo, Photo>(tbb::filter_mode::parallel,
                                        [this](const Photo& taken) {
                                          const PhotoFeed::Item& item = taken->item;
                                          if (item.photo)
                                            taken->photo =
                                                uavs_[item.input].chain.prepare(*item.photo);
                                          return taken;
                                        }) &
         tbb::make_filter<Photo, Step>(kInOrder,
                                       [this](const Photo& taken) { return push(*taken); });
}

ChainSteps::Photo ChainSteps::takeUp(tbb::flow_control& control) {
  auto item = feed_.next();
  if (!item) {
    control.stop();
    return nullptr;
  }
  auto taken = std::make_shared<Taken>();
  taken->item = std::move(*item);
  taken->next_from = follows() && taken->item.photo ? taken->item.photo->time
                                                    : nextOf(feed_.inputs()[taken->item.input]);
  greet(taken->item);
  taken->taken_s = follows() ? taken->item.ready_s : wallSeconds();
  if (!taken->item.photo) return taken;
  gate_.enter();
  if (!follows()) taken->taken_s = pacer_.await(*taken->item.photo);
  most_behind_s_ = std::max(most_behind_s_, wallSeconds() - taken->taken_s);
  return taken;
}

/// What is known when the UAV's first item is taken up.
void ChainSteps::greet(const PhotoFeed::Item& item) {
  Uav& uav = uavs_[item.input];
  if (uav.greeted) return;
  uav.greeted = true;
  SeamHello& hello = hellos_[item.input];
  std::vector<std::string> warnings = std::move(hello.warnings);
  hello = helloOf(feed_.inputs()[item.input], world_);
  hello.warnings = std::move(warnings);
  if (item.photo) {
    hello.next_from = item.photo->time;
    if (hello.photos) ++*hello.photos;
  }
  uav.writer.write(hello);
}

StepSource::Step ChainSteps::push(const Taken& taken) {
  const PhotoFeed::Item& item = taken.item;
  auto out = std::make_shared<SourceStep>();
  out->taken_s = taken.taken_s;
  if (!item.photo) {
    out->step = finish(item.input, item.fixes);
    return out;
  }
  Uav& uav = uavs_[item.input];
  const ImageFrame& frame = taken.photo->frame;
  out->photo = frame;
  gate_.leave();
  const SeamMessage message =
      SeamStep{uav.chain.push(*taken.photo, item.fixes),
               SeamStep::Photo{frame.name, frame.time, frame.camera}, taken.next_from};
  uav.writer.write(message);
  out->step = std::get<SeamStep>(message).step;
  return out;
}

ChainStep ChainSteps::finish(std::size_t input, const std::vector<GnssFix>& fixes) {
  Uav& uav = uavs_[input];
  SeamMessage message = SeamStep{uav.chain.finish(fixes), {}, kNever};
  uav.writer.write(message);
  uav.done = uav.chain.done();
  if (follows()) {
    const SeamHello& hello = hellos_[input];
    const std::vector<std::string>& all = feed_.inputs()[input].warnings();
    if (hello.warnings.empty()) uav.done.warnings = all;
    for (const std::string& warning : uav.done.warnings) {
      warnings_.push_back(hello.name + ": " + warning);
      logWarning(warnings_.back());
    }
  }
  uav.writer.write(uav.done);
  return std::move(std::get<SeamStep>(message).step);
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
