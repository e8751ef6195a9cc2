// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "cf/align/aligner.h"
#include "cf/base/stopwatch.h"
#include "cf/deliver/cloud_sketch.h"
#include "cf/geodesy/grid_frame.h"
#include "cf/pipeline/run_options.h"
#include "cf/types/image_frame.h"
#include "dense_matching.h"
#include "memory_plan.h"
#include "photo_store.h"

namespace cf {

struct DenseSummary {
  std::size_t depth_frames = 0;
  std::map<std::string, int> failures;  ///< pairs without a depth frame, by code
  std::size_t points = 0;               ///< delivered
  double voxel_m = 0;
  CloudSketch cloud;  ///< what the report shows of it
  std::map<FrameId, double>
      finished_s;  ///< wall time at which first something of a photo was fused
};

/// Where a run writes.
struct WorkFolders {
  std::filesystem::path outdir;
  std::filesystem::path work;  ///< what only lives as long as the run
};

/// The map with the final poses: the depth of all stereo pairs, as far as it was matched in the
/// flight already, fused into tiles, clouds, OctoMap and rasters. `photos` by UAV. When the cloud
/// and the OctoMap are written, `beside` is called in this thread, while the others are at the
/// orthophoto (or before, if `memory` says that one must come after the other); it is called once,
/// whatever the map holds.
void mapDensely(const std::vector<std::vector<ImageFrame>>& photos, const Alignment& alignment,
                const GridFrame& grid, const RunOptions& options, const MemoryPlan& memory,
                const WorkFolders& folders, DenseMatching& matching, PhotoStore& store,
                StageTimes& times, const std::function<void(const DenseSummary&)>& beside);

}  // namespace cf
