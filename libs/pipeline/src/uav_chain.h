// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "cf/base/progress.h"
#include "cf/base/stopwatch.h"
#include "cf/deliver/run_record.h"
#include "cf/geodesy/local_frame.h"
#include "cf/georeference/georeferencer.h"
#include "cf/odometry/odometry.h"
#include "cf/pipeline/run_options.h"
#include "cf/rawlog/rawlog_reader.h"

namespace cf {

/// What one UAV's chain hands over the seam at the end of playback, and what is told of it.
struct ChainResult {
  std::vector<GeoKeyframe> keyframes;
  std::vector<GeoSegment> segments;
  UavRecord record;               ///< all but what only the centre knows: final poses, camera after
  std::vector<double> arrival_s;  ///< wall time at which each photo was taken up, by photo
};

/// Plays one UAV's recording through odometry and georeference: the part of the system that can
/// run aboard. Without a `world` (no fix at all) everything stays in local frames.
ChainResult playUav(const UavRecording& recording, const std::string& name, std::uint16_t uav,
                    const std::optional<LocalFrame>& world, const RunOptions& options,
                    TimeNs first_time, StageTimes& times, Progress& progress);

}  // namespace cf
