// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "pacer.h"

#include <fmt/format.h>

#include <chrono>
#include <thread>

#include "cf/base/log.h"
#include "cf/base/stopwatch.h"

namespace cf {
namespace {

std::string durationText(double duration_s) {
  constexpr double kHour_s = 3600, kDay_s = 24 * kHour_s;
  if (duration_s >= 2 * kDay_s) return fmt::format("{:.0f} days", duration_s / kDay_s);
  if (duration_s >= 2 * kHour_s) return fmt::format("{:.1f} hours", duration_s / kHour_s);
  return fmt::format("{:.0f} s", duration_s);
}

}  // namespace

double Pacer::await(const ImageFrame& photo) {
  const double now = wallSeconds();
  if (options_.rate <= 0) return now;
  Passed next{photo.time, now};
  if (last_) {
    const double gap_s = seconds(photo.time - last_->time);
    double wait_s = gap_s / options_.rate;
    if (wait_s > options_.max_gap_s) {
      wait_s = options_.max_gap_s;
      logInfo(fmt::format("playback: {} without a photo before {}: cut to {:g} s",
                          durationText(gap_s), photo.name, wait_s));
    }
    next.moment_s = last_->moment_s + wait_s;
  }
  last_ = next;
  if (next.moment_s > now)
    std::this_thread::sleep_for(std::chrono::duration<double>(next.moment_s - now));
  return next.moment_s;
}

}  // namespace cf
