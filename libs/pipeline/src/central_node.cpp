// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "central_node.h"

#include <iterator>
#include <utility>

namespace cf {

CentralNode::CentralNode(const AlignOptions& options, std::uint16_t center, std::size_t uavs,
                         PhotoStore& store, StageTimes& times)
    : aligner_(options, center),
      update_every_(options.update_every),
      cameras_(uavs),
      store_(store),
      times_(times),
      segments_(uavs),
      gnss_(uavs),
      online_(uavs) {}

void CentralNode::receive(ChainStep step) {
  if (!step.provisional.empty()) store_.put(step.provisional.back().photo, step.jpeg);
  const StageTimes::Scope scope(times_, "align");
  if (step.segments) segments_[step.uav] = step.segments;
  gnss_[step.uav] = step.gnss;
  for (const GeoKeyframe& keyframe : step.keyframes) {
    aligner_.push(keyframe);
    features_[keyframe.keyframe->id] = keyframe.keyframe->features;
    if (keyframe.fix) fixes_[keyframe.keyframe->id] = *keyframe.fix;
    ++keyframes_since_update_;
  }
  for (const ChainStep::Provisional& photo : step.provisional)
    outside_.insert_or_assign(photo.photo, photo);
  const bool joins = step.segments && aligner_.canJoin(*step.segments);
  if (update_every_ > 0 && (keyframes_since_update_ >= update_every_ || joins)) {
    version_ = &aligner_.update(segments(), gnss_, cameras_);
    keyframes_since_update_ = 0;
    for (const auto& [id, entry] : version_->poses) outside_.erase(id);
  }
  if (step.provisional.empty()) return;
  const ChainStep::Provisional& newest = step.provisional.back();
  if (const auto S_world_local = aligner_.similarity(newest.photo, newest.segment))
    online_[step.uav].push_back({newest.photo.index, S_world_local->carry(newest.T_local_cam)});
  else if (newest.T_world_cam)
    online_[step.uav].push_back({newest.photo.index, *newest.T_world_cam});
}

PoseTable CentralNode::mapOfNow() const {
  PoseTable table;
  if (version_ == nullptr) return table;
  table = *version_;
  for (const auto& [id, photo] : outside_) {
    const auto S_world_local = aligner_.similarity(id, photo.segment);
    const auto after = table.poses.lower_bound(id);
    if (!S_world_local || after == table.poses.begin()) continue;
    const auto& [before, entry] = *std::prev(after);
    if (before.uav != id.uav) continue;
    PoseTable::Entry carried = entry;  // it sees ground as far off as the photo before
    carried.covariance = {};
    carried.T_world_cam = S_world_local->carry(photo.T_local_cam);
    table.poses[id] = carried;
  }
  return table;
}

Alignment CentralNode::finish() {
  const StageTimes::Scope scope(times_, "align", CpuClock::kProcess);
  return aligner_.solve(segments(), gnss_, cameras_,
                        [this](FrameId photo) { return store_.grey(photo); });
}

std::vector<Eigen::Vector2f> CentralNode::pixelsOf(const std::vector<SparsePoint>& points) const {
  std::vector<Eigen::Vector2f> pixels;
  for (const SparsePoint& point : points)
    for (const SparseObservation& o : point.observations)
      pixels.push_back(features_.at(o.frame)->pixel[static_cast<std::size_t>(o.feature)]);
  return pixels;
}

std::vector<GeoSegment> CentralNode::segments() const {
  std::vector<GeoSegment> all;
  for (const auto& of_uav : segments_)
    if (of_uav) all.insert(all.end(), of_uav->begin(), of_uav->end());
  return all;
}

}  // namespace cf
