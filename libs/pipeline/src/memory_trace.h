// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

#include "cf/deliver/run_record.h"

namespace cf {

/// Notes, in a thread of its own, the memory of this process from its construction on: at most
/// kMost samples, further apart the longer it lasts.
class MemoryTrace {
 public:
  static constexpr std::size_t kMost = 500;

  MemoryTrace();
  ~MemoryTrace();
  MemoryTrace(const MemoryTrace&) = delete;
  MemoryTrace& operator=(const MemoryTrace&) = delete;

  /// Those until now, in time order.
  std::vector<MemorySample> samples() const;

 private:
  void run();

  double started_s_;
  mutable std::mutex mutex_;
  std::condition_variable stop_;
  bool stopped_ = false;
  std::vector<MemorySample> samples_;
  std::thread thread_;
};

}  // namespace cf
