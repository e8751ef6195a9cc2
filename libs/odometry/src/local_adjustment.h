// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "local_map.h"

namespace cf {

/// Bundle adjustment of the photos `window` of one segment and the landmarks that they see, in
/// place: the cost of equation (1), the robust sum of the residuals of equation (3) on the
/// normalized plane with the inverse depths of equation (2). Final photos, and photos outside the
/// window, are held; if none is, the first of the window is, and the distance to the second.
/// Observations worse than `threshold` afterwards are removed, landmarks left with one observation
/// dropped.
void adjustLocally(LocalMap& map, const std::vector<PhotoIndex>& window, double threshold);

}  // namespace cf
