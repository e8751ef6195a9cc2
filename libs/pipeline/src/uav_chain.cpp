// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "uav_chain.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "cf/base/log.h"
#include "cf/types/sim3.h"
#include "photo_decoder.h"

namespace cf {
namespace {

/// Half a photo is common to a stereo pair: of twice the pixels it keeps the resolution matched.
constexpr double kDensePixels = 2;

}  // namespace

UavChain::UavChain(const std::string& name, std::uint16_t uav,
                   const std::optional<LocalFrame>& world, const RunOptions& options,
                   StageTimes& times)
    : options_(options),
      times_(times),
      uav_(uav),
      odometry_(options.odometry),
      georeferencer_(uav, options.georeference,
                     [&world](const GnssFix& fix) {
                       return world->toEnu(fix.latitude_deg, fix.longitude_deg, fix.height_m);
                     }),
      has_world_(world.has_value()),
      name_(name) {
  done_.uav = uav;
}

std::shared_ptr<ReadyPhoto> UavChain::prepare(const ImageFrame& photo) const {
  auto taken = [&] {
    const StageTimes::Scope scope(times_, "decode");
    return takePhoto(photo, std::max(options_.odometry.features.megapixels,
                                     kDensePixels * options_.densify.megapixels));
  }();
  auto out = std::make_shared<ReadyPhoto>();
  out->frame = photo;
  if (!taken) {
    out->damage = taken.failure().detail;
    return out;
  }
  const StageTimes::Scope scope(times_, "odometry");
  out->jpeg = std::move(taken.value().jpeg);
  out->frame.image = taken.value().image;
  out->photo = preparePhoto(out->frame, options_.odometry);
  out->frame.image.release();
  return out;
}

ChainStep UavChain::push(ReadyPhoto& photo, const std::vector<GnssFix>& fixes) {
  const ImageFrame& frame = photo.frame;
  PhotoRecord& record = done_.photos.emplace_back();
  record.name = frame.name;
  record.time = frame.time;
  ChainStep step;
  step.uav = uav_;
  addFixes(fixes);
  step.gnss = georeferencer_.quality();
  if (!photo.damage.empty()) {
    record.status = PhotoStatus::kDamaged;
    record.reason = photo.damage;
    logWarning(fmt::format("{}: photo {} is skipped: {}", name_, frame.name, photo.damage));
    return step;
  }
  std::vector<std::shared_ptr<const Keyframe>> keyframes;
  {
    const StageTimes::Scope scope(times_, "odometry");
    keyframes = odometry_.push(frame, std::move(photo.photo));
  }
  georeference(keyframes, step);
  step.provisional = provisional();
  step.jpeg = std::move(photo.jpeg);
  return step;
}

ChainStep UavChain::finish(const std::vector<GnssFix>& fixes) {
  ChainStep step;
  step.uav = uav_;
  std::vector<std::shared_ptr<const Keyframe>> keyframes;
  {
    const StageTimes::Scope scope(times_, "odometry");
    keyframes = odometry_.flush();
  }
  addFixes(fixes);
  georeference(keyframes, step);
  const StageTimes::Scope scope(times_, "georeference");
  collect(georeferencer_.flush(), step);
  step.segments = std::make_shared<std::vector<GeoSegment>>(georeferencer_.segments());
  step.gnss = georeferencer_.quality();
  return step;
}

SeamDone UavChain::done() {
  done_.segments = static_cast<int>(georeferencer_.segments().size());
  done_.gnss = georeferencer_.quality();
  done_.pose_graph = georeferencer_.graphText();
  for (const ScaleSample& s : georeferencer_.scaleHistory())
    if (s.georeferenced) done_.scale_history.push_back({s.time, s.segment, s.scale, s.sigma});
  return std::move(done_);
}

void UavChain::addFixes(const std::vector<GnssFix>& fixes) {
  if (!has_world_) return;
  for (const GnssFix& fix : fixes) georeferencer_.addFix(fix);
}

void UavChain::georeference(const std::vector<std::shared_ptr<const Keyframe>>& keyframes,
                            ChainStep& step) {
  const StageTimes::Scope scope(times_, "georeference");
  for (const auto& keyframe : keyframes) {
    PhotoRecord& record = done_.photos[keyframe->id.index];
    record.segment = keyframe->segment;
    record.matches = keyframe->matches;
    record.inliers = keyframe->inliers;
    done_.local_trajectory.push_back({keyframe->id.index, keyframe->T_local_cam});
    collect(georeferencer_.push(keyframe), step);
  }
  step.segments = std::make_shared<std::vector<GeoSegment>>(georeferencer_.segments());
  step.gnss = georeferencer_.quality();
}

void UavChain::collect(std::vector<GeoKeyframe> keyframes, ChainStep& step) {
  for (GeoKeyframe& keyframe : keyframes) {
    local_[keyframe.keyframe->id] = keyframe.keyframe->T_local_cam;
    step.keyframes.push_back(std::move(keyframe));
  }
}

/// Each carried on from the last keyframe of its segment that is georeferenced.
std::vector<ChainStep::Provisional> UavChain::provisional() {
  std::vector<ChainStep::Provisional> out;
  for (const Keyframe& photo : odometry_.provisional()) {
    done_.photos[photo.id.index].keypoints = static_cast<int>(photo.inverse_depth.size());
    out.push_back({photo.id, photo.segment, photo.T_local_cam, {}});
    for (const GeoSegment& segment : georeferencer_.segments()) {
      if (segment.id.segment != photo.segment || !segment.georeferenced || segment.poses.empty())
        continue;
      const auto& last = segment.poses.back();
      out.back().T_world_cam = similarityAt(segment.scale, last.T_world_cam, local_.at(last.frame))
                                   .carry(photo.T_local_cam);
    }
  }
  return out;
}

}  // namespace cf
