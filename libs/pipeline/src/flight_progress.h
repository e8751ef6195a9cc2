// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "step_source.h"

namespace cf {

/// Where the flight is, on stderr, a line for each UAV:
///
///   north   12/75 photos   0.52/s  scale 7.31 +- 0.02  inliers 312  lag 1.2 s
///
/// photos taken up (of those known from the start), per second of late, metres per unit of visual
/// odometry with σ, features that agree with the newest final pose, and how long after the photo
/// was there; "-" for what is not known. On a terminal the lines are drawn in place, at most once a
/// second; otherwise they are printed every 30 seconds, and at the end.
class FlightProgress {
 public:
  /// Lag is shown in real time only.
  FlightProgress(const StepSource& source, bool in_real_time);
  ~FlightProgress();
  FlightProgress(const FlightProgress&) = delete;
  FlightProgress& operator=(const FlightProgress&) = delete;

  void advance(const SourceStep& step);
  std::vector<std::string> lines() const;

 private:
  struct Uav {
    std::string name;
    std::size_t known = 0;  ///< photos; 0: more may come
    std::size_t photos = 0;
    std::deque<double> lately_s;  ///< wall times of the last ones
    std::string scale = "-";
    std::optional<int> inliers;
    std::optional<double> lag_s;
  };
  void print(bool last);

  const bool terminal_, in_real_time_;
  std::vector<Uav> uavs_;
  std::map<std::uint16_t, std::size_t> of_uav_;  ///< by number: place in uavs_
  double printed_s_;
};

}  // namespace cf
