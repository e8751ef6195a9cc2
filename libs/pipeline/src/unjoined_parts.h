// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "cf/deliver/run_record.h"
#include "cf/types/pose_table.h"

namespace cf {

/// A sentence for each UAV, or part of one with more than three photos, that no match joins to the
/// map of the central UAV (component 0): which photos, whether GNSS places them, and what to do.
std::vector<std::string> unjoinedParts(const std::vector<UavRecord>& uavs, const PoseTable& table);

}  // namespace cf
