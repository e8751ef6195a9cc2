// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "cf/deliver/run_record.h"

namespace cf {

/// A sentence for each UAV whose GNSS bias, as estimated through the photos, is far from those of
/// the others (more than receivers usually disagree). Of two UAVs neither can be told to be right.
/// UAVs whose GNSS is missing or not trusted say nothing.
std::vector<std::string> gnssDisagreements(const std::vector<UavRecord>& uavs);

}  // namespace cf
