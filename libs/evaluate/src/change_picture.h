// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "change_regions.h"
#include "height_change.h"

namespace cf {

/// Writes a PNG: the shaded relief of run B, ground that only one run measured darker, changes blue
/// where B is higher and red where it is lower, the stronger the larger; the largest have their
/// number in the list. A legend below. At most 1,600 pixels wide or high without it.
void writeChangePicture(const std::filesystem::path& path, const HeightChange& change,
                        const ChangeRegions& regions);

}  // namespace cf
