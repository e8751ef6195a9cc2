// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "cf/base/stopwatch.h"
#include "cf/deliver/deliver_options.h"
#include "cf/deliver/dsm.h"
#include "cf/densify/densify.h"
#include "cf/geodesy/grid_frame.h"
#include "cf/types/image_frame.h"
#include "photo_store.h"

namespace cf {

/// dsm.tif and orthophoto.tif of a run. The orthophoto is made of the photos as recorded: they are
/// decoded once more for it.
class MapRasters {
 public:
  MapRasters(const DeliverOptions& options, const GridFrame& grid, double voxel_m);

  /// A tile of the finished cloud.
  void add(const Tile& tile);

  /// Writes dsm.tif into `outdir`, if it or the orthophoto is wanted and there is a surface;
  /// `cloud` holds the tiles.
  void writeDsm(TileStore& cloud, const std::filesystem::path& outdir, StageTimes& times);
  /// Writes orthophoto.tif beside it, if wanted, and takes away a dsm.tif that is not. `views` of
  /// `photos` (by UAV). `matched_pixel_m`: its size on the ground.
  void writeOrthophoto(const std::vector<DenseView>& views,
                       const std::vector<std::vector<ImageFrame>>& photos, const PhotoStore& store,
                       double matched_pixel_m, int crops_mb, const std::filesystem::path& outdir,
                       StageTimes& times) const;

 private:
  const DeliverOptions& options_;
  const GridFrame& grid_;
  DsmBuilder dsm_;
};

}  // namespace cf
