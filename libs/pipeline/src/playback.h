// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <vector>

#include "central_node.h"
#include "cf/pipeline/run_options.h"
#include "cf/rawlog/rawlog_reader.h"
#include "live_map.h"
#include "uav_chain.h"

namespace cf {

/// How the playback went.
struct Played {
  /// Wall time at which each photo was taken, as the playback's clock has it, by UAV and photo.
  std::vector<std::vector<double>> taken_s;
  double most_behind_s = 0;  ///< that a photo was taken up later than its moment, in real time
};

/// Plays all recordings side by side, photos in time order (ties by UAV), at options.rate times
/// real time (0: as fast as possible), through their chains to the centre. Photos are decoded and
/// searched for features several at a time; odometry, and the centre, take them up in order, beside
/// one another: while the centre solves, chains go on, up to a bounded number of photos ahead. The
/// result depends neither on timing nor on the number of threads. Each version of the map goes to
/// `live`, if there is one, beside all this.
Played playFlight(const std::vector<UavRecording>& recordings, std::deque<UavChain>& chains,
                  const PlaybackOptions& options, CentralNode& centre, LiveMap* live);

}  // namespace cf
