// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include "flight.h"

namespace cf {

/// What became of a flight that has photos.
ImportedUav describe(const Flight& flight, const std::filesystem::path& rawlog);

/// A configuration for cf-run: UAVs named after their rawlogs; follow_s above 0 is for those that
/// grow. The file appears whole or not at all. Throws RunError.
void writeConfig(const std::vector<std::filesystem::path>& rawlogs, double follow_s,
                 const std::filesystem::path& file);

}  // namespace cf
