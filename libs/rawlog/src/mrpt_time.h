// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/core/Clock.h>

#include <optional>

#include "cf/base/time.h"

namespace cf {

// MRPT counts 100 ns steps from 1601-01-01.
inline constexpr std::int64_t kTicksTo1970 = 116'444'736'000'000'000;
inline constexpr std::int64_t kNsPerTick = 100;

inline mrpt::Clock::time_point mrptTime(TimeNs t) {
  const std::int64_t ticks = t >= 0 ? t / kNsPerTick : -((-t + kNsPerTick - 1) / kNsPerTick);
  return mrpt::Clock::time_point(mrpt::Clock::duration(ticks + kTicksTo1970));
}

/// None before 1970 and from 2200 on: there the time was never set, or is damaged.
inline std::optional<TimeNs> timeOf(mrpt::Clock::time_point t) {
  constexpr std::int64_t kTicksTo2200 = kTicksTo1970 + 7'258'118'400 * (kNsPerSecond / kNsPerTick);
  const auto ticks = static_cast<std::int64_t>(t.time_since_epoch().count());
  if (ticks < kTicksTo1970 || ticks >= kTicksTo2200) return std::nullopt;
  return (ticks - kTicksTo1970) * kNsPerTick;
}

}  // namespace cf
