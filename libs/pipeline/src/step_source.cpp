// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "step_source.h"

#include <algorithm>

namespace cf {

std::size_t StepSource::photoCount() const {
  std::size_t count = 0;
  for (const SeamHello& hello : hellos_) count += hello.photos.size();
  return count;
}

std::vector<StepSource::Place> StepSource::order() const {
  std::vector<Place> places;
  for (std::size_t u = 0; u < hellos_.size(); ++u)
    for (std::uint32_t i = 0; i < hellos_[u].photos.size(); ++i) places.push_back({u, i});
  const auto timeOf = [&](const Place& p) { return hellos_[p.uav].photos[p.photo].time; };
  // Of one UAV always in its own order.
  std::stable_sort(places.begin(), places.end(),
                   [&](const Place& a, const Place& b) { return timeOf(a) < timeOf(b); });
  for (std::size_t u = 0; u < hellos_.size(); ++u)
    places.push_back({u, static_cast<std::uint32_t>(hellos_[u].photos.size())});
  return places;
}

}  // namespace cf
