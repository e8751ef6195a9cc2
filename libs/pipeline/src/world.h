// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "cf/deliver/run_record.h"
#include "cf/geodesy/grid_frame.h"
#include "cf/geodesy/local_frame.h"
#include "cf/pipeline/run_options.h"

namespace cf {

/// Where the map lies.
struct World {
  std::optional<LocalFrame> frame;  ///< none: no photo has a GNSS position, the map is relative
  GridFrame grid;
  WorldRecord record;

  /// Places it on earth; heights count from `datum`.
  void setFrame(const LocalFrame& on_earth, HeightDatum datum);
};

/// Place of the central UAV in the configuration.
std::uint16_t centralUav(const RunOptions& options);

/// The world's origin: as configured, or the first fix of the central UAV, or, where it has none,
/// of the first that has. `first_fixes` by UAV.
World placeWorld(const RunOptions& options, const std::vector<std::optional<GnssFix>>& first_fixes);

}  // namespace cf
