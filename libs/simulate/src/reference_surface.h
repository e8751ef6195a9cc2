// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include "cluster_flight.h"

namespace cf {

/// truth/cloud.ply and truth/dsm.tif: the topmost surface on a grid, where at least one photo sees
/// it.
void writeReferenceSurface(const Scene& scene, const std::vector<PlannedUav>& uavs,
                           const LocalFrame& world, double spacing_m,
                           const std::filesystem::path& truth);

}  // namespace cf
