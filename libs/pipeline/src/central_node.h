// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "cf/align/aligner.h"
#include "cf/base/stopwatch.h"
#include "cf/types/chain_step.h"
#include "cf/types/photo_record.h"
#include "photo_store.h"

namespace cf {

/// Receives what the UAVs hand over the seam, in time order, and keeps the common map up to date:
/// a new version every `[align] update_every` keyframes, and when another UAV can join, whatever
/// the time that solving takes.
class CentralNode {
 public:
  /// What is given by reference must outlive the node.
  CentralNode(const AlignOptions& options, std::uint16_t center, std::size_t uavs,
              PhotoStore& store, StageTimes& times);

  /// A UAV's camera, as given: before its first step.
  void introduce(std::uint16_t uav, const CameraModel& camera) { cameras_[uav] = camera; }

  void receive(ChainStep step);
  /// The newest version of the map, and in it the photos that have come since, carried on by their
  /// odometry. Empty before the first version.
  PoseTable mapOfNow() const;
  /// The final map, when all steps have come.
  Alignment finish();
  /// Where the photos saw the points, of all their observations in order.
  std::vector<Eigen::Vector2f> pixelsOf(const std::vector<SparsePoint>& points) const;

  /// Each photo's pose as the cluster knew it when the photo had been processed, by UAV: carried on
  /// from the common map, or, where its segment is not in it yet, as the UAV knew it alone.
  const std::vector<std::vector<PhotoPose>>& onlineTrajectories() const { return online_; }
  /// What the receivers said at the photos' times.
  const std::map<FrameId, GnssPosition>& fixes() const { return fixes_; }
  /// By UAV, as given.
  const std::vector<CameraModel>& cameras() const { return cameras_; }

 private:
  std::vector<GeoSegment> segments() const;

  Aligner aligner_;
  const int update_every_;
  std::vector<CameraModel> cameras_;
  PhotoStore& store_;
  StageTimes& times_;
  std::vector<std::shared_ptr<const std::vector<GeoSegment>>> segments_;  ///< by UAV
  std::vector<GnssQuality> gnss_;                                         ///< by UAV
  std::vector<std::vector<PhotoPose>> online_;
  const PoseTable* version_ = nullptr;                 ///< newest, the aligner's
  std::map<FrameId, ChainStep::Provisional> outside_;  ///< photos that it does not hold
  std::map<FrameId, std::shared_ptr<const FeatureSet>> features_;
  std::map<FrameId, GnssPosition> fixes_;
  int keyframes_since_update_ = 0;
};

}  // namespace cf
