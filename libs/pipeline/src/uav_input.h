// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "cf/base/stopwatch.h"
#include "cf/formats/arriving_file.h"
#include "cf/pipeline/run_options.h"
#include "cf/rawlog/rawlog_follower.h"

namespace cf {

/// One UAV's photos and fixes, taken as the configuration wants: of a rawlog that is complete, or,
/// with [playback] follow_s, of one that may still grow.
class UavInput {
 public:
  /// The UAV at that place of the configuration. Throws UsageError where photos have no
  /// calibration, RunError where the rawlog cannot be read.
  UavInput(const Config& config, const RunOptions& options, std::uint16_t uav);

  std::uint16_t uav() const { return uav_; }
  const std::string& name() const { return name_; }

  /// A photo that was not taken up yet.
  struct Waiting {
    ImageFrame photo;  ///< without pixels
    double came_s;     ///< wall time
    ArrivingFile file;
  };
  /// In time order.
  std::deque<Waiting>& photos() { return photos_; }
  const std::deque<Waiting>& photos() const { return photos_; }
  /// Those up to a time, in order, once.
  std::vector<GnssFix> takeFixes(TimeNs until);
  std::size_t fixes() const { return fixes_.size(); }  ///< not taken yet
  /// Of all that came; none if there is none.
  const std::optional<GnssFix>& firstFix() const { return first_fix_; }

  /// Reads on.
  void look();
  /// Takes the rest: nothing more is waited for.
  void close();
  bool isClosed() const { return !follower_; }
  /// No photo of this time or before is still to come.
  TimeNs knownUntil() const { return known_until_; }
  /// Wall time at which the rawlog was last seen to grow.
  double grown_s() const { return grown_s_; }
  /// About the recording, when it is closed.
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  void add(UavRecording recording);

  const std::uint16_t uav_;
  const std::string name_;
  std::filesystem::path rawlog_;
  std::optional<Eigen::Vector3d> sigma_enu_m_;
  std::optional<CameraModel> camera_;
  std::optional<RawlogFollower> follower_;
  std::deque<Waiting> photos_;
  std::deque<GnssFix> fixes_;
  std::optional<GnssFix> first_fix_;
  TimeNs known_until_;
  double grown_s_ = wallSeconds();
  std::vector<std::string> warnings_;
};

}  // namespace cf
