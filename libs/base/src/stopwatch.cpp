// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/base/stopwatch.h"

#include <sys/resource.h>

#include <chrono>
#include <utility>

namespace cf {

double wallSeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
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

StageTimes::Scope::Scope(StageTimes& times, std::string stage)
    : times_(times),
      stage_(std::move(stage)),
      wall_start_(wallSeconds()),
      cpu_start_(processCpuSeconds()) {}

StageTimes::Scope::~Scope() {
  const double wall = wallSeconds() - wall_start_;
  const double cpu = processCpuSeconds() - cpu_start_;
  const std::lock_guard<std::mutex> lock(times_.mutex_);
  auto& sum = times_.seconds_[stage_];
  sum.wall_s += wall;
  sum.cpu_s += cpu;
}

std::map<std::string, StageSeconds> StageTimes::all() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return seconds_;
}

}  // namespace cf
