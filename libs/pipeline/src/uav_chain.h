// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cf/base/stopwatch.h"
#include "cf/formats/seam_message.h"
#include "cf/geodesy/local_frame.h"
#include "cf/georeference/georeferencer.h"
#include "cf/odometry/odometry.h"
#include "cf/pipeline/run_options.h"
#include "cf/types/chain_step.h"

namespace cf {

/// A photo decoded and searched for features, ready for odometry.
struct ReadyPhoto {
  ImageFrame frame;  ///< without pixels
  PreparedPhoto photo;
  std::string jpeg;    ///< as the central node gets it
  std::string damage;  ///< why it cannot be used; empty: it can
};

/// One UAV's odometry and georeference: the part of the system that can run aboard.
class UavChain {
 public:
  /// Without a `world` (no fix at all) everything stays in local frames. What is given by
  /// reference must outlive the chain.
  UavChain(const std::string& name, std::uint16_t uav, const std::optional<LocalFrame>& world,
           const RunOptions& options, StageTimes& times);

  /// Needs nothing of the photos before: may run for several at a time, and beside push().
  std::shared_ptr<ReadyPhoto> prepare(const ImageFrame& photo) const;
  /// In order; with the fixes that came since the photo before, up to its time.
  ChainStep push(ReadyPhoto& photo, const std::vector<GnssFix>& fixes);
  /// What is left after the last photo.
  ChainStep finish(const std::vector<GnssFix>& fixes);
  /// After finish(): what the report tells of the UAV, as far as it knows it itself.
  SeamDone done();

 private:
  void addFixes(const std::vector<GnssFix>& fixes);
  void georeference(const std::vector<std::shared_ptr<const Keyframe>>& keyframes, ChainStep& step);
  void collect(std::vector<GeoKeyframe> keyframes, ChainStep& step);
  std::vector<ChainStep::Provisional> provisional();

  const RunOptions& options_;
  StageTimes& times_;
  const std::uint16_t uav_;
  Odometry odometry_;
  Georeferencer georeferencer_;
  const bool has_world_;
  std::map<FrameId, Eigen::Isometry3d> local_;
  const std::string name_;
  SeamDone done_;
};

}  // namespace cf
