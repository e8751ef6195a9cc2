// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cf/base/options.h"

namespace cf {

/// [fuse]
struct FuseOptions {
  double voxel_m = 0;         ///< 0 = automatic: the caller sets the ground size of a matched pixel
  double tile_m = 50;         ///< side of a tile
  int max_memory_mb = 400;    ///< tiles in memory beyond it are written and leave
  int min_views = 1;          ///< delivered voxels were seen by so many depth frames
  double min_confidence = 0;  ///< and have this sum of weights
  int trusted_views = 3;      ///< voxels seen by so many are never taken for flying points

  void visit(OptionVisitor& visitor);
};

}  // namespace cf
