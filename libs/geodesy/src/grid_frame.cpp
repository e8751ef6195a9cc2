// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/geodesy/grid_frame.h"

#include <fmt/format.h>

#include "cf/base/error.h"

namespace cf {

GridFrame::GridFrame(const LocalFrame& world, HeightDatum datum)
    : world_(world),
      zone_(utmZoneOf(world.origin().latitude_deg, world.origin().longitude_deg)),
      datum_(datum) {}

Eigen::Vector3d GridFrame::toGrid(const Eigen::Vector3d& p_world) const {
  if (!world_) return p_world;
  const Geodetic p = world_->toGeodetic(p_world);
  const Result<UtmPosition> utm = geodeticToUtm(zone_, p);
  if (!utm)
    throw RunError(fmt::format("a point at latitude {}, longitude {} is outside UTM zone {}: {}",
                               p.latitude_deg, p.longitude_deg, zone_.text(),
                               utm.failure().detail));
  return {utm->easting_m, utm->northing_m, p.height_m};
}

Eigen::Vector3d GridFrame::toWorld(const Eigen::Vector3d& p_grid) const {
  if (!world_) return p_grid;
  const Result<Geodetic> p = utmToGeodetic(zone_, p_grid.x(), p_grid.y(), p_grid.z());
  if (!p)
    throw RunError(fmt::format("easting {}, northing {} is outside UTM zone {}: {}", p_grid.x(),
                               p_grid.y(), zone_.text(), p.failure().detail));
  return world_->toEnu(*p);
}

Eigen::Affine3d GridFrame::T_grid_world(const Eigen::Vector3d& near_world) const {
  if (!world_) return Eigen::Affine3d::Identity();
  constexpr double kStep_m = 50;  // central differences: free of the quadratic terms
  Eigen::Affine3d T = Eigen::Affine3d::Identity();
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d step = kStep_m * Eigen::Vector3d::Unit(axis);
    T.linear().col(axis) = (toGrid(near_world + step) - toGrid(near_world - step)) / (2 * kStep_m);
  }
  T.translation() = toGrid(near_world) - T.linear() * near_world;
  return T;
}

}  // namespace cf
