// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "cf/deliver/run_record.h"

namespace cf {

int countOf(const UavRecord& uav, PhotoStatus status);

struct PhotoTotals {
  int total = 0;
  int posed = 0;
};
PhotoTotals totalsOf(const RunRecord& run);

/// Seconds: percentiles by nearest rank; zero if there are none.
struct Latency {
  double p50 = 0, p95 = 0, max = 0;
};
Latency latencyOf(const std::vector<PhotoLatency>& latencies);

}  // namespace cf
