// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include "cf/align/aligner.h"
#include "cf/base/stopwatch.h"
#include "cf/geodesy/grid_frame.h"
#include "cf/pipeline/run_options.h"
#include "cf/types/image_frame.h"

namespace cf {

struct DenseSummary {
  std::size_t depth_frames = 0;
  std::map<std::string, int> failures;  ///< pairs without a depth frame, by code
  std::size_t points = 0;               ///< delivered
  double voxel_m = 0;
  std::map<FrameId, double> finished_s;  ///< wall time at which a photo was fused
};

/// Virtual stereo pairs of every posed photo, matched side by side and fused in the order of the
/// photos into tiles, clouds and OctoMap below `outdir`. `photos` by UAV.
DenseSummary mapDensely(const std::vector<std::vector<ImageFrame>>& photos,
                        const Alignment& alignment, const GridFrame& grid,
                        const RunOptions& options, const std::filesystem::path& outdir,
                        StageTimes& times);

}  // namespace cf
