// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>

#include "cf/base/time.h"
#include "cf/types/gnss_fix.h"

namespace cf {

/// Fixes of one UAV by time, interpolated to the times of its photos.
class FixTrack {
 public:
  FixTrack(double max_gap_s, double acceleration_sigma_mps2)
      : max_gap_s_(max_gap_s), acceleration_sigma_mps2_(acceleration_sigma_mps2) {}

  void add(TimeNs time, const GnssPosition& position) { fixes_[time] = position; }
  /// True when no later fix can change at(time).
  bool reaches(TimeNs time) const;
  /// Linear between the two fixes around `time`; none outside the fixes or across an outage.
  std::optional<GnssPosition> at(TimeNs time) const;
  /// Drops what no photo at or after `time` needs.
  void forgetBefore(TimeNs time);

 private:
  double max_gap_s_;
  double acceleration_sigma_mps2_;
  std::map<TimeNs, GnssPosition> fixes_;
};

}  // namespace cf
