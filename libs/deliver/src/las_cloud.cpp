// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/deliver/las_cloud.h"

#include <algorithm>

#include "cf/formats/crs_wkt.h"

namespace cf {

LasCloud::LasCloud(const std::filesystem::path& path, const GridFrame& grid)
    : grid_(grid),
      las_(path, grid.toGrid(Eigen::Vector3d::Zero()),
           grid.relative() ? "" : crsWkt(grid.epsg(), grid.datum())) {}

void LasCloud::add(const Tile& tile) {
  if (tile.points.empty()) return;
  Eigen::AlignedBox3f box;
  for (const TilePoint& p : tile.points) box.extend(p.position_m);
  const Eigen::Affine3d T_grid_tile =
      grid_.T_grid_world(tile.offset_m + box.center().cast<double>()) *
      Eigen::Translation3d(tile.offset_m);
  for (const TilePoint& p : tile.points)
    las_.add({T_grid_tile * p.position_m.cast<double>(),
              {p.bgr[2], p.bgr[1], p.bgr[0]},
              static_cast<std::uint8_t>(std::min<int>(p.views, 255))});
}

}  // namespace cf
