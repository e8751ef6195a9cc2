// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/import/timing.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <optional>
#include <set>

namespace cf {
namespace {

constexpr TimeNs kMicrosecond = 1000;
using MaybeTimes = std::vector<std::optional<TimeNs>>;

TimeNs medianOf(std::vector<TimeNs> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// GPS times that a receiver without reception repeats while the camera's clock runs are no use.
bool gpsIsFresh(const std::vector<PhotoTime>& tags) {
  std::set<TimeNs> gps, camera;
  for (const PhotoTime& t : tags) {
    if (t.camera && !t.gps) return false;
    if (t.gps) gps.insert(*t.gps);
    if (t.camera) camera.insert(*t.camera);
  }
  constexpr double kFresh = 0.9;
  return !gps.empty() &&
         static_cast<double>(gps.size()) >= kFresh * static_cast<double>(camera.size());
}

MaybeTimes byCamera(const std::vector<PhotoTime>& tags, std::string& source) {
  std::vector<TimeNs> offsets;
  for (const PhotoTime& t : tags)
    if (t.gps && t.camera) offsets.push_back(*t.gps - *t.camera);
  const TimeNs offset = offsets.empty() ? 0 : medianOf(offsets);
  source = offsets.empty() ? "camera clock taken as UTC" : "camera clock set by GPS";
  MaybeTimes times(tags.size());
  for (std::size_t i = 0; i < tags.size(); ++i) {
    if (tags[i].camera)
      times[i] = *tags[i].camera + offset;
    else
      times[i] = tags[i].gps;
  }
  return times;
}

TimeNs usualStep(const MaybeTimes& times) {
  std::vector<TimeNs> sorted, steps;
  for (const auto& t : times)
    if (t) sorted.push_back(*t);
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t i = 1; i < sorted.size(); ++i)
    if (sorted[i] > sorted[i - 1]) steps.push_back(sorted[i] - sorted[i - 1]);
  return steps.empty() ? kNsPerSecond : medianOf(steps);
}

/// Gives a time to every photo, from its neighbours by name.
std::vector<TimeNs> filled(const MaybeTimes& times) {
  const TimeNs step = usualStep(times);
  std::vector<TimeNs> out(times.size());
  std::optional<std::size_t> before;
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (times[i]) {
      out[i] = *times[i];
      before = i;
      continue;
    }
    std::size_t after = i;
    while (after < times.size() && !times[after]) ++after;
    const bool has_after = after < times.size();
    const auto steps = [](std::size_t n) { return static_cast<TimeNs>(n); };
    if (before && has_after && *times[after] > *times[*before])
      out[i] = *times[*before] +
               (*times[after] - *times[*before]) / steps(after - *before) * steps(i - *before);
    else if (before)
      out[i] = *times[*before] + step * steps(i - *before);
    else if (has_after)
      out[i] = *times[after] - step * steps(after - i);
    else
      out[i] = step * steps(i);
  }
  return out;
}

void spreadEqualTimes(std::vector<TimeNs>& times) {
  for (TimeNs& t : times) t -= t % kMicrosecond;
  std::vector<std::size_t> order(times.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return times[a] < times[b]; });
  for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    const TimeNs t = times[order[begin]];
    while (end < order.size() && times[order[end]] == t) ++end;
    const auto count = static_cast<TimeNs>(end - begin);
    const TimeNs span =
        end == order.size() ? kNsPerSecond : std::min(times[order[end]] - t, kNsPerSecond);
    for (TimeNs k = 1; k < count; ++k) {
      const TimeNs later = span * k / count;
      times[order[begin + static_cast<std::size_t>(k)]] = t + later - later % kMicrosecond;
    }
  }
}

}  // namespace

FlightTimes flightTimes(const std::vector<PhotoTime>& tags) {
  FlightTimes result;
  MaybeTimes times(tags.size());
  if (gpsIsFresh(tags)) {
    result.source = "GPS";
    for (std::size_t i = 0; i < tags.size(); ++i) times[i] = tags[i].gps;
  } else {
    times = byCamera(tags, result.source);
  }
  const auto untimed = std::count(times.begin(), times.end(), std::nullopt);
  if (untimed == static_cast<std::ptrdiff_t>(tags.size()) && untimed != 0) {
    result.source = "none: one a second in order of the names";
    result.warnings.push_back("no photo has a time: taken as one a second in order of the names");
  } else if (untimed != 0) {
    result.warnings.push_back(
        fmt::format("{} photos have no time: placed between their neighbours by name", untimed));
  }
  result.times = filled(times);
  spreadEqualTimes(result.times);
  return result;
}

}  // namespace cf
