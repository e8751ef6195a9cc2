// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "cf/formats/las.h"
#include "cf/geodesy/grid_frame.h"
#include "cf/types/tile.h"

namespace cf {

/// The dense cloud as LAS 1.4 in the grid of the map: UTM and height, or, of a relative map, the
/// map's own coordinates without a reference system. User data: the depth frames that saw a point,
/// at most 255.
class LasCloud {
 public:
  /// RunError, here and below, where the file cannot be written.
  LasCloud(const std::filesystem::path& path, const GridFrame& grid);
  void add(const Tile& tile);
  /// Without it there is no file.
  void close() { las_.close(); }

 private:
  const GridFrame& grid_;
  LasWriter las_;
};

}  // namespace cf
