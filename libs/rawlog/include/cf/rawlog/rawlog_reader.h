// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "cf/rawlog/rawlog_writer.h"
#include "cf/types/gnss_fix.h"
#include "cf/types/image_frame.h"

namespace cf {

/// What one UAV recorded, in time order.
struct UavRecording {
  std::vector<ImageFrame> photos;  ///< without pixels; id.index counts from 0, id.uav is 0
  std::vector<GnssFix> fixes;      ///< may be empty
  std::vector<std::string> warnings;
};

/// Standard deviations for rawlogs that carry none of their own (docs/rawlog.md).
inline constexpr double kDefaultSigmaHorizontal_m = 2.0;
inline constexpr double kDefaultSigmaVertical_m = 4.0;

/// Reads a rawlog of ours or of anybody else's that holds CObservationImage with externally stored
/// images, and CObservationGPS with GGA messages. A rawlog that breaks off gives what could be
/// read, and a warning. Images stored inside the rawlog, outside of its folder of images, and
/// without a calibration are left out or kept as docs/rawlog.md says, with a warning.
/// Throws RunError if the file cannot be read at all; UsageError if a label does not occur, or is
/// empty while several sensors of that kind occur.
UavRecording readRecording(const std::filesystem::path& rawlog, const RawlogLabels& labels = {});

}  // namespace cf
