// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/fuse/fuse_options.h"

namespace cf {

void FuseOptions::visit(OptionVisitor& visitor) {
  visitor.number("voxel_m", voxel_m, {0, 100},
                 "side of a voxel [m]; 0 = ground size of a matched pixel");
  visitor.number("tile_m", tile_m, {1, 10000}, "side of a tile [m]");
  visitor.integer("max_memory_mb", max_memory_mb, {16, 1 << 20},
                  "memory for tiles [MB]; beyond it the longest unused are written and leave");
  visitor.integer("min_views", min_views, {1, 65535},
                  "delivered points were seen by at least so many depth frames");
  visitor.number("min_confidence", min_confidence, {0, 1e30},
                 "delivered points have at least this sum of weights");
  visitor.integer("trusted_views", trusted_views, {1, 65535},
                  "points seen by so many depth frames are never removed as flying points");
}

}  // namespace cf
