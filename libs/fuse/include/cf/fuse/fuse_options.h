// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cf/base/options.h"

namespace cf {

/// Section [fuse].
struct FuseOptions {
  double voxel_m = 0;         ///< 0 = automatic, see resolved()
  double tile_m = 0;          ///< side of a tile; 0 = automatic
  int max_memory_mb = 300;    ///< tiles in memory beyond it are written and leave
  int min_views = 1;          ///< delivered voxels were seen by so many depth frames
  double min_confidence = 0;  ///< and have this sum of weights
  int trusted_views = 3;      ///< voxels seen by so many are never taken for flying points

  void visit(OptionVisitor& visitor);
  /// With what is automatic chosen: voxels of the ground size of a matched pixel, tiles of about
  /// 300 voxels in whole metres. A photo then covers some ten tiles, so that those in memory are
  /// mostly those in view.
  FuseOptions resolved(double matched_pixel_m) const;
};

}  // namespace cf
