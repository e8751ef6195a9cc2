// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "cf/types/tile.h"

namespace cf {

/// The tile without flying points. A voxel seen by `trusted_views` depth frames or more always
/// stays. Of the others it removes those
/// - that stand alone: with a tenth of the voxels around them that the tile's surfaces have (the
///   median, so it holds for any density), or fewer;
/// - of islets: connected sets of fewer than 30 voxels;
/// - of small islands (fewer than 500 voxels) that hang above or below a larger surface which at
///   least twice as many depth frames saw in the same vertical column;
/// - seen by a fifth or fewer of the depth frames that saw another voxel in the columns around: the
///   rest looked there and saw the surface elsewhere.
/// Ground that only one pair saw stays, since it is wide or joins what others saw; so do poles and
/// edges, which join the ground or a roof.
///
/// `neighbours` are the tiles around it as far as they exist, raw like `tile`: what lies across the
/// border supports too. `voxel_m` is the side of their voxels.
Tile cleaned(const Tile& tile, const std::vector<const Tile*>& neighbours, double voxel_m,
             int trusted_views);

}  // namespace cf
