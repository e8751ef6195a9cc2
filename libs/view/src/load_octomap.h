// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include "cf/view/scene_inputs.h"

namespace cf {

/// The occupied voxels of a colour OctoMap (.ot), at the finest level that has at most
/// `max_voxels` of them. Throws RunError naming the file if it is absent or no colour OctoMap.
std::vector<Voxel> loadVoxels(const std::filesystem::path& file, std::size_t max_voxels);

}  // namespace cf
