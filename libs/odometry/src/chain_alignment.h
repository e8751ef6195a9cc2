// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "local_map.h"

namespace cf {

/// Moves the features of a posed photo that see landmarks to where the grey values around the
/// landmarks' first sights fit best (alignPatch). A detector finds the middle of a blob to a few
/// tenths of a pixel, each photo anew; aligned, the sights of a landmark agree to a few hundredths.
/// Those that cannot be aligned stay as they are, outside the chain.
void alignToLandmarks(LocalMap& map, PhotoIndex photo);

}  // namespace cf
