// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <tbb/global_control.h>

#include "cf/pipeline/run_options.h"

namespace cf {

/// [system] threads, or one for each core.
int threadsOf(const RunOptions& options);

/// [system] threads, as long as it lives.
class ThreadLimit {
 public:
  explicit ThreadLimit(const RunOptions& options);

 private:
  tbb::global_control limit_;
};

}  // namespace cf
