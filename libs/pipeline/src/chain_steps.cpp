// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "chain_steps.h"

#include <algorithm>
#include <utility>

#include "cf/base/log.h"

namespace cf {
namespace {

SeamHello helloOf(const UavInput& input) {
  SeamHello hello;
  hello.uav = input.uav();
  hello.name = input.name();
  return hello;
}

/// What is known when all has been read.
void complete(SeamHello& hello, const UavInput& input, const std::optional<LocalFrame>& world) {
  hello.first_fix = input.firstFix();
  hello.warnings = input.warnings();
  if (!hello.first_fix || !world) return;
  const Geodetic& origin = world->origin();
  hello.origin = {origin.latitude_deg, origin.longitude_deg, origin.height_m};
}

void add(const ImageFrame& photo, SeamHello& hello) {
  if (hello.photos.empty()) hello.camera = photo.camera;
  hello.photos.push_back({photo.name, photo.time});
}

}  // namespace

ChainSteps::ChainSteps(PhotoFeed feed, const RunOptions& options,
                       const std::optional<LocalFrame>& world, StageTimes& times,
                       const std::filesystem::path& seam)
    : feed_(std::move(feed)), world_(world), pacer_(options.playback) {
  for (const UavInput& input : feed_.inputs()) {
    const auto file = seam.empty() ? seam : seam / (input.name() + ".seam");
    uavs_.emplace_back(input, options, world, times, file);
    hellos_.push_back(helloOf(input));
    if (follows()) continue;
    complete(hellos_.back(), input, world);
    for (const UavInput::Waiting& waiting : input.photos()) add(waiting.photo, hellos_.back());
    uavs_.back().writer.write(hellos_.back());
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
  taken->taken_s = follows() ? taken->item.ready_s : wallSeconds();
  if (!taken->item.photo) return taken;
  if (!follows()) taken->taken_s = pacer_.await(*taken->item.photo);
  most_behind_s_ = std::max(most_behind_s_, wallSeconds() - taken->taken_s);
  return taken;
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
  if (follows()) add(*item.photo, hellos_[item.input]);
  out->photo = taken.photo->frame;
  SeamMessage message = uav.chain.push(*taken.photo, item.fixes);
  uav.writer.write(message);
  out->step = std::move(std::get<ChainStep>(message));
  return out;
}

ChainStep ChainSteps::finish(std::size_t input, const std::vector<GnssFix>& fixes) {
  Uav& uav = uavs_[input];
  SeamMessage message = uav.chain.finish(fixes);
  uav.writer.write(message);
  uav.done = uav.chain.done();
  uav.writer.write(uav.done);
  if (follows()) {
    SeamHello& hello = hellos_[input];
    complete(hello, feed_.inputs()[input], world_);
    uav.writer.write(hello);  // only counted, so that it may come last
    for (const std::string& warning : hello.warnings) {
      warnings_.push_back(hello.name + ": " + warning);
      logWarning(warnings_.back());
    }
  }
  return std::move(std::get<ChainStep>(message));
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
