// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "memory_trace.h"

#include <chrono>

#include "cf/base/stopwatch.h"
#include "free_memory.h"

namespace cf {
namespace {

constexpr double kFirstInterval_s = 0.25;

}  // namespace

MemoryTrace::MemoryTrace() : started_s_(wallSeconds()), thread_([this] { run(); }) {}

MemoryTrace::~MemoryTrace() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopped_ = true;
  }
  stop_.notify_all();
  thread_.join();
}

std::vector<MemorySample> MemoryTrace::samples() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return samples_;
}

void MemoryTrace::run() {
  std::unique_lock<std::mutex> lock(mutex_);
  double interval_s = kFirstInterval_s;
  while (!stopped_) {
    samples_.push_back({wallSeconds() - started_s_, residentMegabytes()});
    if (samples_.size() >= kMost) {  // every other one
      for (std::size_t i = 0; 2 * i < samples_.size(); ++i) samples_[i] = samples_[2 * i];
      samples_.resize((samples_.size() + 1) / 2);
      interval_s *= 2;
    }
    stop_.wait_for(lock, std::chrono::duration<double>(interval_s), [this] { return stopped_; });
  }
}

}  // namespace cf
