// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/base/stopwatch.h"

#include <sys/resource.h>

#include <chrono>
#include <ctime>
#include <utility>

namespace cf {

double wallSeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double threadCpuSeconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double processCpuSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto sum = [](const timeval& a, const timeval& b) {
    return static_cast<double>(a.tv_sec + b.tv_sec) +
           1e-6 * static_cast<double>(a.tv_usec + b.tv_usec);
  };
  return sum(usage.ru_utime, usage.ru_stime);
}

double peakRssMegabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

StageTimes::Scope::Scope(StageTimes& times, std::string stage, CpuClock clock)
    : times_(times),
      stage_(std::move(stage)),
      clock_(clock),
      cpu_start_(clock == CpuClock::kThread ? threadCpuSeconds() : processCpuSeconds()) {
  const std::lock_guard<std::mutex> lock(times_.mutex_);
  Stage& entry = times_.stages_[stage_];
  if (entry.active++ == 0) entry.active_since = wallSeconds();
}

StageTimes::Scope::~Scope() {
  const double cpu_end = clock_ == CpuClock::kThread ? threadCpuSeconds() : processCpuSeconds();
  const std::lock_guard<std::mutex> lock(times_.mutex_);
  Stage& entry = times_.stages_[stage_];
  entry.sum.cpu_s += cpu_end - cpu_start_;
  if (--entry.active == 0) entry.sum.wall_s += wallSeconds() - entry.active_since;
}

std::map<std::string, StageSeconds> StageTimes::all() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::map<std::string, StageSeconds> sums;
  for (const auto& [name, stage] : stages_) sums[name] = stage.sum;
  return sums;
}

}  // namespace cf
