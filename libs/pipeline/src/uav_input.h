// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "cf/pipeline/run_options.h"
#include "cf/rawlog/rawlog_reader.h"

namespace cf {

/// One UAV's recording, as the configuration wants it to be taken.
struct UavInput {
  std::uint16_t uav = 0;  ///< place in the configuration
  std::string name;
  UavRecording recording;
};

/// Reads the UAV at that place of the configuration. Throws UsageError where photos have no
/// calibration, RunError where the rawlog cannot be read.
UavInput readUav(const Config& config, const RunOptions& options, std::uint16_t uav);

/// In time; none if there is none.
std::optional<GnssFix> firstFix(const UavRecording& recording);

}  // namespace cf
