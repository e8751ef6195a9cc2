// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <vector>

#include "central_node.h"
#include "cf/rawlog/rawlog_reader.h"
#include "uav_chain.h"

namespace cf {

/// Plays all recordings side by side, photos in time order (ties by UAV), at `rate` times real time
/// (0: as fast as possible), through their chains to the centre. Photos are decoded and searched
/// for features several at a time; odometry, and the centre, take them up in order, beside one
/// another: while the centre solves, chains go on, up to a bounded number of photos ahead. The
/// result depends neither on timing nor on the number of threads. Returns the wall time at which
/// each photo was taken up, by UAV and photo.
std::vector<std::vector<double>> playFlight(const std::vector<UavRecording>& recordings,
                                            std::deque<UavChain>& chains, double rate,
                                            CentralNode& centre);

}  // namespace cf
