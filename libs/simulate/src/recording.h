// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include "cluster_flight.h"

namespace cf {

/// The rawlog of one UAV and, beside it, its empty folder of images.
void writeRawlog(const PlannedUav& uav, const std::filesystem::path& outdir);

/// config.ini as cf-import writes it, and the world's origin.
void writeRunConfig(const SimulationSetup& setup, const std::vector<PlannedUav>& uavs,
                    const std::filesystem::path& file);

/// Takes a photo into the images beside the rawlog. Seconds that it took.
double writePhoto(const PlannedUav& uav, const PlannedPhoto& photo, const Scene& scene,
                  const PhotoOptions& options, const std::filesystem::path& outdir);

/// truth/depth/<uav>/<stem>.tif of about this many megapixels.
void writeDepth(const PlannedUav& uav, const PlannedPhoto& photo, const Scene& scene,
                const PhotoOptions& options, double megapixels, const std::filesystem::path& truth);

}  // namespace cf
