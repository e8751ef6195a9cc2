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

void World::setFrame(const LocalFrame& on_earth, HeightDatum datum) {
  frame = on_earth;
  grid = GridFrame(on_earth, datum);
  record.relative = false;
  record.latitude_deg = on_earth.origin().latitude_deg;
  record.longitude_deg = on_earth.origin().longitude_deg;
  record.height_m = on_earth.origin().height_m;
  record.h_datum = datum;
  record.utm = on_earth.utmZone();
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
  world.setFrame(LocalFrame(origin), first->datum);
  return world;
}

}  // namespace cf
