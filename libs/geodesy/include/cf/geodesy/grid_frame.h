// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "cf/geodesy/local_frame.h"
#include "cf/geodesy/utm.h"
#include "cf/types/gnss_fix.h"

namespace cf {

/// The coordinates in which maps are handed out: easting, northing and height [m] in the UTM zone
/// of the world's origin. Heights count from what the origin's height counts from (`datum`). The
/// grid of a relative map, which has no place on earth, is the map's own x, y, z.
class GridFrame {
 public:
  /// Of a relative map.
  GridFrame() = default;
  GridFrame(const LocalFrame& world, HeightDatum datum);

  bool relative() const { return !world_; }
  HeightDatum datum() const { return datum_; }
  /// EPSG code of the horizontal system, e.g. 32615; 0 for a relative map.
  int epsg() const { return world_ ? zone_.epsg() : 0; }

  /// Exact both ways. Throws RunError where a position is outside what UTM covers.
  Eigen::Vector3d toGrid(const Eigen::Vector3d& p_world) const;
  Eigen::Vector3d toWorld(const Eigen::Vector3d& p_grid) const;
  /// p_grid = T * p_world around a position: within 0.5 mm at 50 m from it, 1 mm at 80 m.
  Eigen::Affine3d T_grid_world(const Eigen::Vector3d& near_world) const;

 private:
  std::optional<LocalFrame> world_;
  UtmZone zone_;
  HeightDatum datum_ = HeightDatum::kUnknown;
};

}  // namespace cf
