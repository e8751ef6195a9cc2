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
#include "world.h"

namespace cf {
namespace {

constexpr auto kPoll = std::chrono::milliseconds(100);
/// A wait of this length is worth a word.
constexpr double kSay_s = 2;

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& what) {
  throw RunError(file.string() + ": " + what);
}

bool isUsable(const CameraModel& camera) {
  return camera.width > 0 && camera.height > 0 && camera.fx > 0 && camera.fy > 0;
}

/// That nothing in it points outside of the UAV's photos, of which there were `before`.
bool fits(const SeamStep& message, std::uint16_t uav, std::size_t before) {
  const ChainStep& step = message.step;
  const std::size_t photos = before + (message.photo ? 1 : 0);
  const auto isOwn = [&](FrameId id) { return id.uav == uav && id.index < photos; };
  const auto fit = [&](const GeoSegment& segment) {
    return segment.id.uav == uav &&
           std::all_of(segment.poses.begin(), segment.poses.end(),
                       [&](const GeoSegment::Pose& pose) { return isOwn(pose.frame); });
  };
  const auto isProvisional = [&](const ChainStep::Provisional& p) { return isOwn(p.photo); };
  return step.uav == uav && (!message.photo || isUsable(message.photo->camera)) &&
         std::all_of(step.provisional.begin(), step.provisional.end(), isProvisional) &&
         (step.provisional.empty() ||
          (message.photo && step.provisional.back().photo.index == before)) &&
         std::all_of(step.keyframes.begin(), step.keyframes.end(),
                     [&](const GeoKeyframe& k) { return isOwn(k.keyframe->id); }) &&
         (!step.segments || std::all_of(step.segments->begin(), step.segments->end(), fit));
}

bool fits(const SeamDone& done, std::uint16_t uav, std::size_t photos) {
  return done.uav == uav && done.photos.size() == photos &&
         std::all_of(done.local_trajectory.begin(), done.local_trajectory.end(),
                     [&](const PhotoPose& pose) { return pose.photo < photos; });
}

constexpr const char* kUnfit = "its messages do not fit together";

}  // namespace

SeamSteps::SeamSteps(const std::filesystem::path& folder, const RunOptions& options)
    : options_(options.playback) {
  for (const UavOptions& uav : options.uavs) {
    const std::filesystem::path path = folder / (uav.name + ".seam");
    Stream& stream = streams_.emplace_back(path);
    stream.grown_s = wallSeconds();
    SeamHello& hello = hellos_.emplace_back();
    stream.done.uav = hello.uav = static_cast<std::uint16_t>(hellos_.size() - 1);
    hello.name = uav.name;
    hello.photos = 0;
  }
  awaitStart(centralUav(options));
}

void SeamSteps::requireOrigin(const Geodetic& origin) {
  origin_ = origin;
  for (const SeamHello& hello : hellos_) checkOrigin(hello);
}

void SeamSteps::checkOrigin(const SeamHello& hello) const {
  if (!origin_ || !hello.origin) return;
  const Eigen::Vector3d ours(origin_->latitude_deg, origin_->longitude_deg, origin_->height_m);
  if (*hello.origin != ours)
    throw RunError(fmt::format(
        "{}: its agent georeferences at the origin {}, {}, {}, this run at {}, {}, {}: give all of "
        "them the same [world] origin",
        hello.name, hello.origin->x(), hello.origin->y(), hello.origin->z(), ours.x(), ours.y(),
        ours.z()));
}

/// Until the map has a place: as PhotoFeed::awaitStart() of rawlogs.
void SeamSteps::awaitStart(std::size_t center) {
  waiting_since_ = wallSeconds();
  std::optional<double> other_since;
  for (;; std::this_thread::sleep_for(kPoll)) {
    bool all = true, other = false;
    for (std::size_t u = 0; u < streams_.size(); ++u) {
      look(u);
      all = all && (streams_[u].greeted || streams_[u].stopped);
      other = other || hellos_[u].first_fix;
    }
    const double now = wallSeconds();
    if (all || (follows() && hellos_[center].first_fix)) return;
    if (other && !other_since) other_since = now;
    if (follows() && other_since && now - *other_since >= options_.hold_up_s) {
      logInfo(hellos_[center].name + " has no photos with fixes yet: the flight begins without it");
      return;
    }
    for (std::size_t u = 0; u < streams_.size(); ++u)
      if (!streams_[u].greeted && !streams_[u].stopped && isSilent(u)) stop(u);
  }
}

tbb::filter<void, StepSource::Step> SeamSteps::steps() {
  return tbb::make_filter<void, Step>(tbb::filter_mode::serial_in_order,
                                      [this](tbb::flow_control& control) { return next(control); });
}

StepSource::Step SeamSteps::next(tbb::flow_control& control) {
  waiting_since_ = wallSeconds();
  said_ = false;
  for (;; std::this_thread::sleep_for(kPoll)) {
    std::optional<std::size_t> first;
    for (std::size_t u = 0; u < streams_.size(); ++u) {
      look(u);
      const Stream& stream = streams_[u];
      if (stream.head && stream.head->message.photo && (!first || comesBefore(u, *first)))
        first = u;
    }
    bool held_up = false;
    for (std::size_t u = 0; u < streams_.size() && !held_up; ++u) held_up = holdsUp(u, first);
    if (first && !held_up) return take(*first);
    while (!first && !held_up && finished_ < streams_.size()) {
      const std::size_t last = finished_++;
      if (streams_[last].head) return takeLast(last);
    }
    if (!first && !held_up) {
      control.stop();
      return nullptr;
    }
    for (std::size_t u = 0; u < streams_.size(); ++u)
      if (holdsUp(u, first) && isSilent(u)) stop(u);
  }
}

/// Reads the agent's next message if there is none yet; whether there is one now.
bool SeamSteps::look(std::size_t uav) {
  Stream& stream = streams_[uav];
  if (stream.stopped || stream.head) return stream.head.has_value();
  auto message = stream.reader.next();
  if (!message) return false;
  stream.grown_s = wallSeconds();
  if (!stream.greeted) {
    auto* hello = std::get_if<SeamHello>(&*message);
    if (hello == nullptr) refuse(stream.path, "it does not begin as a seam file does");
    greet(uav, std::move(*hello));
    return look(uav);
  }
  auto* step = std::get_if<SeamStep>(&*message);
  const auto number = static_cast<std::uint16_t>(uav);
  if (step == nullptr || !fits(*step, number, stream.came)) refuse(stream.path, kUnfit);
  if (step->photo && step->photo->time < stream.next_from)
    refuse(stream.path, "its photos are not in time order");
  if (step->photo) ++stream.came;
  stream.next_from = step->next_from;
  stream.head = {std::move(*step), wallSeconds()};
  return true;
}

void SeamSteps::greet(std::size_t uav, SeamHello hello) {
  Stream& stream = streams_[uav];
  if (hello.uav != uav || hello.name != hellos_[uav].name)
    refuse(stream.path, fmt::format("it is of UAV {} ({}), not of {} ({}): agents and central "
                                    "node need the same configuration",
                                    hello.uav, hello.name, uav, hellos_[uav].name));
  checkOrigin(hello);
  stream.greeted = true;
  stream.next_from = hello.next_from;
  hellos_[uav] = std::move(hello);
}

/// The photo at hand of `a` before that of `b`.
bool SeamSteps::comesBefore(std::size_t a, std::size_t b) const {
  return std::pair(streams_[a].head->message.photo->time, a) <
         std::pair(streams_[b].head->message.photo->time, b);
}

/// That `other` may have a photo before the one at hand of `first`; without one, that it may have
/// any.
bool SeamSteps::holdsUp(std::size_t other, std::optional<std::size_t> first) const {
  const Stream& stream = streams_[other];
  if (stream.stopped || stream.head) return false;
  if (!first) return true;
  const Head& head = *streams_[*first].head;
  const double now = wallSeconds();
  if (follows() &&
      (now - stream.grown_s >= options_.hold_up_s || now - head.came_s >= options_.hold_up_s))
    return false;
  return !stream.greeted ||
         std::pair(stream.next_from, other) < std::pair(head.message.photo->time, *first);
}

StepSource::Step SeamSteps::take(std::size_t uav) {
  Stream& stream = streams_[uav];
  auto out = std::make_shared<SourceStep>();
  out->taken_s = stream.head->came_s;
  SeamStep message = std::move(stream.head->message);
  stream.head.reset();
  note(uav, message);
  ImageFrame& photo = out->photo.emplace();  // its file is not at hand
  photo.id = {static_cast<std::uint16_t>(uav),
              static_cast<std::uint32_t>(stream.done.photos.size() - 1)};
  photo.name = message.photo->name;
  photo.time = message.photo->time;
  photo.camera = message.photo->camera;
  out->step = std::move(message.step);
  return out;
}

StepSource::Step SeamSteps::takeLast(std::size_t uav) {
  Stream& stream = streams_[uav];
  auto out = std::make_shared<SourceStep>();
  out->taken_s = stream.head->came_s;
  note(uav, stream.head->message);
  out->step = std::move(stream.head->message.step);
  stream.head.reset();
  stream.stopped = true;
  finish(uav);
  return out;
}

/// Of an agent that is waited for: that it has been for too long.
bool SeamSteps::isSilent(std::size_t uav) {
  const double now = wallSeconds();
  if (!said_ && now - waiting_since_ > kSay_s) {
    logInfo("waiting for " + streams_[uav].path.string());
    said_ = true;
  }
  double since = waiting_since_;
  if (follows())  // whoever goes on shows that the flight does
    for (const Stream& stream : streams_) since = std::max(since, stream.grown_s);
  return now - since > longestWait();
}

void SeamSteps::stop(std::size_t uav) {
  Stream& stream = streams_[uav];
  const SeamHello& hello = hellos_[uav];
  stream.stopped = true;
  const double waited_s = longestWait();
  const std::string of = hello.photos ? fmt::format(" of {}", *hello.photos) : std::string();
  warnings_.push_back(
      stream.greeted
          ? fmt::format("{}: its agent has not gone on for {:.0f} s, after {}{} photos; the map is "
                        "made without the rest",
                        hello.name, waited_s, stream.came, of)
          : fmt::format("{}: no agent has written {} within {:.0f} s", hello.name,
                        stream.path.string(), waited_s));
  logWarning(warnings_.back());
}

/// What is told of the UAV if nothing more of it comes.
void SeamSteps::note(std::size_t uav, const SeamStep& message) {
  const ChainStep& step = message.step;
  SeamDone& done = streams_[uav].done;
  done.gnss = step.gnss;
  if (step.segments) done.segments = static_cast<int>(step.segments->size());
  if (message.photo) {
    PhotoRecord& record = done.photos.emplace_back();
    record.name = message.photo->name;
    record.time = message.photo->time;
    record.reason =
        step.provisional.empty() ? "damaged" : "its agent had stopped before it was done";
    if (step.provisional.empty()) record.status = PhotoStatus::kDamaged;
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

/// An agent says that it is done right after its last step.
void SeamSteps::finish(std::size_t uav) {
  Stream& stream = streams_[uav];
  std::optional<SeamMessage> message;
  for (const double since = wallSeconds(); !(message = stream.reader.next());
       std::this_thread::sleep_for(kPoll))
    if (wallSeconds() - since > options_.wait_s) return stop(uav);
  auto* done = std::get_if<SeamDone>(&*message);
  if (done == nullptr || !fits(*done, static_cast<std::uint16_t>(uav), stream.came))
    refuse(stream.path, kUnfit);
  stream.done = std::move(*done);
  for (const std::string& warning : stream.done.warnings) {
    warnings_.push_back(hellos_[uav].name + ": " + warning);
    logWarning(warnings_.back());
  }
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
