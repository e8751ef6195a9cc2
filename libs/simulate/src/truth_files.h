// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include "cluster_flight.h"

namespace cf {

/// Every truth file that needs no pixels (docs/simulate.md): world.json, poses, cameras, GNSS,
/// simulation.json.
void writeTruthFiles(const std::filesystem::path& truth, const SimulationSetup& setup,
                     const LocalFrame& world, const Eigen::AlignedBox2d& area,
                     const std::vector<PlannedUav>& uavs);

}  // namespace cf
