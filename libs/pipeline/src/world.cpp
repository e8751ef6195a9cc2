// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "world.h"

#include <algorithm>

namespace cf {

std::uint16_t centralUav(const RunOptions& options) {
  const auto it = std::find_if(options.uavs.begin(), options.uavs.end(),
                               [&](const auto& uav) { return uav.name == options.cluster.center; });
  return static_cast<std::uint16_t>(it - options.uavs.begin());
}

World placeWorld(const RunOptions& options,
                 const std::vector<std::optional<GnssFix>>& first_fixes) {
  World world;
  world.record.center = options.cluster.center;
  std::optional<GnssFix> first = first_fixes[centralUav(options)];
  for (std::size_t u = 0; !first && u < first_fixes.size(); ++u) first = first_fixes[u];
  if (!first) {
    world.record.relative = true;
    return world;
  }
  Geodetic origin{first->latitude_deg, first->longitude_deg, first->height_m};
  if (!options.world.origin.empty()) {
    const auto p = parseNumbers(options.world.origin, 3, "[world] origin");
    origin = {p[0], p[1], p[2]};
  }
  world.frame.emplace(origin);
  world.grid = GridFrame(*world.frame, first->datum);
  world.record.latitude_deg = origin.latitude_deg;
  world.record.longitude_deg = origin.longitude_deg;
  world.record.height_m = origin.height_m;
  world.record.h_datum = first->datum;
  world.record.utm = world.frame->utmZone();
  return world;
}

}  // namespace cf
