// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <mutex>
#include <vector>

#include "central_node.h"
#include "cf/pipeline/run_options.h"
#include "live_map.h"
#include "memory_plan.h"
#include "step_source.h"

namespace cf {

/// When photos came. Thread-safe.
class PhotoTimes {
 public:
  struct Times {
    double taken_s = 0;     ///< wall time at which it was there to be taken up
    double received_s = 0;  ///< and at which the centre had it
  };
  void set(FrameId photo, const Times& times);
  Times of(FrameId photo) const;

 private:
  mutable std::mutex mutex_;
  std::map<FrameId, Times> times_;
};

/// All steps of the source to the centre, which takes them up in order beside the stages of the
/// source: while the centre solves, these go on, up to a bounded number of photos ahead. The result
/// depends neither on timing nor on the number of threads. What each step adds to the map goes to
/// `live`, if there is one, beside all this. Adds to `photos` (by UAV) and `times` what comes.
/// `memory` says how many photos may be on their way at a time; of each its features and its JPEG
/// are kept.
void playFlight(StepSource& source, const PlaybackOptions& options, const MemoryPlan& memory,
                CentralNode& centre, LiveMap* live, std::vector<std::vector<ImageFrame>>& photos,
                PhotoTimes& times);

}  // namespace cf
