// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "cf/features/match.h"
#include "local_map.h"

namespace cf {

/// Where the features of photo `from` should appear on the normalized plane of photo `to`, both
/// posed in one segment. A feature with a landmark: within `margin` of its projection. Any other:
/// where a depth puts it that the photo's landmarks make likely, give or take `margin`. Without
/// enough landmarks for that, nowhere.
std::vector<SearchDisc> searchDiscs(const LocalMap& map, PhotoIndex from, PhotoIndex to,
                                    double margin);

}  // namespace cf
