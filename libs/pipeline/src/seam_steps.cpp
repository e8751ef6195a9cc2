// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "seam_steps.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>
#include <variant>

#include "cf/base/error.h"
#include "cf/base/log.h"
#include "cf/base/stopwatch.h"

namespace cf {
namespace {

constexpr auto kPoll = std::chrono::milliseconds(200);
/// A wait of this length is worth a word.
constexpr double kSay_s = 2;

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& what) {
  throw RunError(file.string() + ": " + what);
}

/// That nothing in it points outside of what the UAV has said it has.
bool fits(const ChainStep& step, const SeamHello& hello) {
  const auto isOwn = [&](FrameId id) {
    return id.uav == hello.uav && id.index < hello.photos.size();
  };
  const auto fit = [&](const GeoSegment& segment) {
    return segment.id.uav == hello.uav &&
           std::all_of(segment.poses.begin(), segment.poses.end(),
                       [&](const GeoSegment::Pose& pose) { return isOwn(pose.frame); });
  };
  return step.uav == hello.uav && (!step.newest || isOwn(step.newest->photo)) &&
         std::all_of(step.keyframes.begin(), step.keyframes.end(),
                     [&](const GeoKeyframe& k) { return isOwn(k.keyframe->id); }) &&
         (!step.segments || std::all_of(step.segments->begin(), step.segments->end(), fit));
}

bool fits(const SeamDone& done, const SeamHello& hello) {
  return done.uav == hello.uav && done.photos.size() == hello.photos.size() &&
         std::all_of(done.local_trajectory.begin(), done.local_trajectory.end(),
                     [&](const PhotoPose& pose) { return pose.photo < hello.photos.size(); });
}

}  // namespace

SeamSteps::SeamSteps(const std::filesystem::path& folder, const RunOptions& options)
    : wait_s_(options.playback.wait_s) {
  for (const UavOptions& uav : options.uavs) {
    const std::filesystem::path path = folder / (uav.name + ".seam");
    streams_.push_back({path, SeamReader(path), false, {}});
  }
  for (std::uint16_t u = 0; u < streams_.size(); ++u) begin(u, options.uavs[u].name);
  order_ = order();
}

void SeamSteps::begin(std::uint16_t uav, const std::string& name) {
  Stream& stream = streams_[uav];
  SeamHello hello;
  hello.uav = uav;
  hello.name = name;
  if (const auto message = await(stream)) {
    const auto* said = std::get_if<SeamHello>(&*message);
    if (said == nullptr) refuse(stream.path, "it does not begin as a seam file does");
    if (said->uav != uav || said->name != name)
      refuse(stream.path, fmt::format("it is of UAV {} ({}), not of {} ({}): agents and central "
                                      "node need the same configuration",
                                      said->uav, said->name, uav, name));
    if (!std::is_sorted(said->photos.begin(), said->photos.end(),
                        [](const auto& a, const auto& b) { return a.time < b.time; }))
      refuse(stream.path, "its photos are not in time order");
    hello = *said;
  }
  hellos_.push_back(hello);
  stream.done.uav = uav;
  for (const SeamHello::Photo& photo : hello.photos) {
    PhotoRecord record;
    record.name = photo.name;
    record.time = photo.time;
    record.reason = "its agent had stopped before";
    stream.done.photos.push_back(record);
  }
  if (!stream.stopped) return;
  warnings_.push_back(fmt::format("{}: no agent has written {} within {:.0f} s", name,
                                  stream.path.string(), wait_s_));
  logWarning(warnings_.back());
}

std::vector<SeamSteps::Place> SeamSteps::order() const {
  std::vector<Place> places;
  for (std::size_t u = 0; u < hellos_.size(); ++u)
    for (std::uint32_t i = 0; i < hellos_[u].photos.size(); ++i) places.push_back({u, i});
  const auto timeOf = [&](const Place& p) { return hellos_[p.uav].photos[p.photo].time; };
  // Of one UAV always in its own order.
  std::stable_sort(places.begin(), places.end(),
                   [&](const Place& a, const Place& b) { return timeOf(a) < timeOf(b); });
  for (std::size_t u = 0; u < hellos_.size(); ++u)
    places.push_back({u, static_cast<std::uint32_t>(hellos_[u].photos.size())});
  return places;
}

/// Its file is not at hand.
ImageFrame SeamSteps::photoAt(const Place& place) const {
  const SeamHello& hello = hellos_[place.uav];
  ImageFrame photo;
  photo.id = {hello.uav, place.photo};
  photo.name = hello.photos[place.photo].name;
  photo.time = hello.photos[place.photo].time;
  photo.camera = hello.camera;
  return photo;
}

tbb::filter<void, StepSource::Step> SeamSteps::steps() {
  return tbb::make_filter<void, Step>(tbb::filter_mode::serial_in_order,
                                      [this](tbb::flow_control& control) { return next(control); });
}

StepSource::Step SeamSteps::next(tbb::flow_control& control) {
  while (next_ < order_.size()) {
    const Place place = order_[next_++];
    Stream& stream = streams_[place.uav];
    if (stream.stopped) continue;
    auto message = await(stream);
    if (!message) {
      stop(place.uav, place.photo);
      continue;
    }
    auto out = std::make_shared<SourceStep>();
    out->taken_s = wallSeconds();
    auto* step = std::get_if<ChainStep>(&*message);
    if (step == nullptr || !fits(*step, hellos_[place.uav]))
      refuse(stream.path, "its messages do not fit together");
    out->step = std::move(*step);
    note(place.uav, out->step, place);
    if (isLast(place))
      finish(place.uav);
    else
      out->photo = photoAt(place);
    return out;
  }
  control.stop();
  return nullptr;
}

/// The next message; none if the agent has ended without it.
std::optional<SeamMessage> SeamSteps::await(Stream& stream) const {
  const double since = wallSeconds();
  bool said = false;
  while (true) {
    if (auto message = stream.reader.next()) return message;
    const double waited = wallSeconds() - since;
    if (stream.reader.ended() || waited > wait_s_) {
      stream.stopped = true;
      return std::nullopt;
    }
    if (!said && waited > kSay_s) {
      logInfo("waiting for " + stream.path.string());
      said = true;
    }
    std::this_thread::sleep_for(kPoll);
  }
}

void SeamSteps::stop(std::size_t uav, std::size_t photos) {
  warnings_.push_back(
      fmt::format("{}: its agent has not gone on for {:.0f} s, after {} of {} photos; the map is "
                  "made without the rest",
                  hellos_[uav].name, wait_s_, photos, hellos_[uav].photos.size()));
  logWarning(warnings_.back());
}

/// What is told of the UAV if nothing more of it comes.
void SeamSteps::note(std::size_t uav, const ChainStep& step, const Place& place) {
  SeamDone& done = streams_[uav].done;
  done.gnss = step.gnss;
  if (step.segments) done.segments = static_cast<int>(step.segments->size());
  if (!isLast(place)) {
    PhotoRecord& record = done.photos[place.photo];
    record.reason = step.newest ? "its agent had stopped before it was done" : "damaged";
    if (!step.newest) record.status = PhotoStatus::kDamaged;
  }
  for (const GeoKeyframe& geo : step.keyframes) {
    const Keyframe& keyframe = *geo.keyframe;
    PhotoRecord& record = done.photos[keyframe.id.index];
    record.segment = keyframe.segment;
    record.keypoints = static_cast<int>(keyframe.features->size());
    record.matches = keyframe.matches;
    record.inliers = keyframe.inliers;
    record.reason.clear();
    done.local_trajectory.push_back({keyframe.id.index, keyframe.T_local_cam});
  }
}

void SeamSteps::finish(std::size_t uav) {
  Stream& stream = streams_[uav];
  auto message = await(stream);
  if (!message) return stop(uav, hellos_[uav].photos.size());
  auto* done = std::get_if<SeamDone>(&*message);
  if (done == nullptr || !fits(*done, hellos_[uav]))
    refuse(stream.path, "its messages do not fit together");
  stream.done = std::move(*done);
}

std::vector<SeamDone> SeamSteps::done() {
  std::vector<SeamDone> all;
  for (Stream& stream : streams_) all.push_back(std::move(stream.done));
  return all;
}

std::uint64_t SeamSteps::bytes() const {
  std::uint64_t sum = 0;
  for (const Stream& stream : streams_) sum += stream.reader.bytes();
  return sum;
}

}  // namespace cf
