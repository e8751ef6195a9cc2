// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "local_map.h"

namespace cf {

/// Extends landmarks from one posed photo to the other, or triangulates new ones, from the matches
/// of two photos of one segment (a in photo `i`, b in photo `j`). A sight may be off by `threshold`
/// on the normalized plane. A photo sees a landmark once.
void connect(LocalMap& map, PhotoIndex i, PhotoIndex j, const std::vector<FeatureMatch>& matches,
             double threshold);

}  // namespace cf
