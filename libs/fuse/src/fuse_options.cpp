// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/fuse/fuse_options.h"

#include <algorithm>
#include <cmath>

namespace cf {

void FuseOptions::visit(OptionVisitor& visitor) {
  visitor.number("voxel_m", voxel_m, {0, 100},
                 "side of a voxel [m]; 0 = ground size of a matched pixel");
  visitor.number("tile_m", tile_m, {0, 10000},
                 "side of a tile [m], at most 1024 voxels; 0 = about 300 voxels");
  visitor.integer("max_memory_mb", max_memory_mb, {16, 1 << 20},
                  "memory for tiles [MB]; beyond it the longest unused are written and leave");
  visitor.integer("min_views", min_views, {1, 4095},
                  "delivered points were seen by at least so many depth frames");
  visitor.number("min_confidence", min_confidence, {0, 1e30},
                 "delivered points have at least this sum of weights");
  visitor.integer("trusted_views", trusted_views, {1, 4095},
                  "points seen by so many depth frames are never removed as flying points");
}

FuseOptions FuseOptions::resolved(double matched_pixel_m) const {
  constexpr double kTileVoxels = 300;
  FuseOptions result = *this;
  if (result.voxel_m == 0) result.voxel_m = matched_pixel_m;
  if (result.tile_m == 0) result.tile_m = std::max(1.0, std::round(kTileVoxels * result.voxel_m));
  return result;
}

}  // namespace cf
