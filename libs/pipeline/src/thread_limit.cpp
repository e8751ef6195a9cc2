// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "thread_limit.h"

#include <algorithm>
#include <opencv2/core/utility.hpp>
#include <thread>

namespace cf {

int threadsOf(const RunOptions& options) {
  const int threads = options.system.threads > 0
                          ? options.system.threads
                          : static_cast<int>(std::thread::hardware_concurrency());
  return std::max(1, threads);
}

ThreadLimit::ThreadLimit(const RunOptions& options)
    : limit_(tbb::global_control::max_allowed_parallelism,
             static_cast<std::size_t>(threadsOf(options))) {
  // Photos and pairs are worked on side by side; OpenCV's own threads would only get in the way.
  cv::setNumThreads(options.uavs.size() > 1 ? 1 : threadsOf(options));
}

}  // namespace cf
