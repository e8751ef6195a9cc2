// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "uav_chain.h"

#include <fmt/format.h>
#include <tbb/parallel_pipeline.h>

#include <chrono>
#include <limits>
#include <thread>

#include "cf/base/log.h"
#include "cf/georeference/frames.h"
#include "photo_decoder.h"

namespace cf {
namespace {

/// Real-time playback: waits until the photo's moment has come.
void keepPace(TimeNs since_first, double rate, double started_s) {
  if (rate <= 0) return;
  const double due = started_s + seconds(since_first) / rate;
  const double wait = due - wallSeconds();
  if (wait > 0) std::this_thread::sleep_for(std::chrono::duration<double>(wait));
}

/// Photos of one UAV decoded and searched for features ahead of odometry, each with its pixels.
constexpr std::size_t kPhotosAhead = 4;

/// A photo ready for odometry.
struct Prepared {
  ImageFrame frame;  ///< without pixels
  PreparedPhoto photo;
  std::string damage;  ///< why it cannot be used; empty: it can
};

class Chain {
 public:
  Chain(const UavRecording& recording, const std::string& name, std::uint16_t uav,
        const std::optional<LocalFrame>& world, const RunOptions& options, StageTimes& times)
      : recording_(recording),
        options_(options),
        times_(times),
        odometry_(options.odometry),
        georeferencer_(uav, options.georeference,
                       [&world](const GnssFix& fix) {
                         return world->toEnu(fix.latitude_deg, fix.longitude_deg, fix.height_m);
                       }),
        has_world_(world.has_value()) {
    result_.record.name = name;
    result_.arrival_s.resize(recording.photos.size());
    for (const ImageFrame& photo : recording.photos) {
      PhotoRecord record;
      record.name = photo.name;
      record.time = photo.time;
      result_.record.photos.push_back(record);
    }
  }

  void addFixesUntil(TimeNs time) {
    const auto& fixes = recording_.fixes;
    for (; has_world_ && next_fix_ < fixes.size() && fixes[next_fix_].time <= time; ++next_fix_)
      georeferencer_.addFix(fixes[next_fix_]);
  }

  void note(const ImageFrame& photo) { result_.arrival_s[photo.id.index] = wallSeconds(); }

  /// Needs nothing of the photos before: may run for several at a time.
  std::shared_ptr<Prepared> prepare(const ImageFrame& photo) const {
    const auto decoded = [&] {
      const StageTimes::Scope scope(times_, "decode");
      return decodePhoto(photo, options_.odometry.features.megapixels);
    }();
    auto out = std::make_shared<Prepared>();
    out->frame = photo;
    if (!decoded) {
      out->damage = decoded.failure().detail;
      return out;
    }
    const StageTimes::Scope scope(times_, "odometry");
    out->frame.image = decoded.value();
    out->photo = preparePhoto(out->frame, options_.odometry);
    out->frame.image.release();
    return out;
  }

  void push(Prepared& photo) {
    const ImageFrame& frame = photo.frame;
    addFixesUntil(frame.time);
    if (!photo.damage.empty()) {
      PhotoRecord& record = result_.record.photos[frame.id.index];
      record.status = PhotoStatus::kDamaged;
      record.reason = photo.damage;
      logWarning(fmt::format("{}: photo {} is skipped: {}", result_.record.name, frame.name,
                             photo.damage));
      return;
    }
    std::vector<std::shared_ptr<const Keyframe>> keyframes;
    {
      const StageTimes::Scope scope(times_, "odometry");
      keyframes = odometry_.push(frame, std::move(photo.photo));
    }
    georeference(keyframes);
    noteOnline(frame.id.index, odometry_.newest());
  }

  ChainResult finish() {
    {
      const StageTimes::Scope scope(times_, "odometry");
      last_ = odometry_.flush();
    }
    addFixesUntil(std::numeric_limits<TimeNs>::max());
    georeference(last_);
    const StageTimes::Scope scope(times_, "georeference");
    collect(georeferencer_.flush());
    result_.segments = georeferencer_.segments();
    result_.record.segments = static_cast<int>(result_.segments.size());
    result_.record.gnss = georeferencer_.quality();
    result_.record.pose_graph = georeferencer_.graphText();
    for (const ScaleSample& s : georeferencer_.scaleHistory())
      if (s.georeferenced)
        result_.record.scale_history.push_back({s.time, s.segment, s.scale, s.sigma});
    return std::move(result_);
  }

 private:
  void georeference(const std::vector<std::shared_ptr<const Keyframe>>& keyframes) {
    const StageTimes::Scope scope(times_, "georeference");
    for (const auto& keyframe : keyframes) {
      PhotoRecord& record = result_.record.photos[keyframe->id.index];
      record.segment = keyframe->segment;
      record.matches = keyframe->matches;
      record.inliers = keyframe->inliers;
      result_.record.local_trajectory.push_back({keyframe->id.index, keyframe->T_local_cam});
      collect(georeferencer_.push(keyframe));
    }
  }

  void collect(std::vector<GeoKeyframe> keyframes) {
    for (GeoKeyframe& keyframe : keyframes) {
      local_[keyframe.keyframe->id] = keyframe.keyframe->T_local_cam;
      result_.keyframes.push_back(std::move(keyframe));
    }
  }

  /// The newest photo's pose as the UAV knows it now: carried on from the last keyframe of its
  /// segment that is georeferenced.
  void noteOnline(std::uint32_t index, const Keyframe& newest) {
    result_.record.photos[index].keypoints = static_cast<int>(newest.inverse_depth.size());
    for (const GeoSegment& segment : georeferencer_.segments()) {
      if (segment.id.segment != newest.segment || !segment.georeferenced || segment.poses.empty())
        continue;
      const auto& last = segment.poses.back();
      const Sim3 S_world_local =
          similarityAt(segment.scale, last.T_world_cam, local_.at(last.frame));
      result_.record.online_trajectory.push_back({index, S_world_local.carry(newest.T_local_cam)});
    }
  }

  const UavRecording& recording_;
  const RunOptions& options_;
  StageTimes& times_;
  Odometry odometry_;
  Georeferencer georeferencer_;
  const bool has_world_;
  std::size_t next_fix_ = 0;
  std::vector<std::shared_ptr<const Keyframe>> last_;
  std::map<FrameId, Eigen::Isometry3d> local_;
  ChainResult result_;
};

}  // namespace

ChainResult playUav(const UavRecording& recording, const std::string& name, std::uint16_t uav,
                    const std::optional<LocalFrame>& world, const RunOptions& options,
                    TimeNs first_time, StageTimes& times, Progress& progress) {
  Chain chain(recording, name, uav, world, options, times);
  const double started = wallSeconds();
  std::size_t next = 0;
  tbb::parallel_pipeline(
      kPhotosAhead,
      tbb::make_filter<void, std::size_t>(tbb::filter_mode::serial_in_order,
                                          [&](tbb::flow_control& control) -> std::size_t {
                                            if (next == recording.photos.size()) {
                                              control.stop();
                                              return next;
                                            }
                                            const ImageFrame& photo = recording.photos[next];
                                            keepPace(photo.time - first_time, options.playback.rate,
                                                     started);
                                            chain.note(photo);
                                            return next++;
                                          }) &
          tbb::make_filter<std::size_t, std::shared_ptr<Prepared>>(
              tbb::filter_mode::parallel,
              [&](std::size_t i) { return chain.prepare(recording.photos[i]); }) &
          tbb::make_filter<std::shared_ptr<Prepared>, void>(
              tbb::filter_mode::serial_in_order, [&](const std::shared_ptr<Prepared>& photo) {
                chain.push(*photo);
                progress.advance(name);
              }));
  return chain.finish();
}

}  // namespace cf
