// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "cf/align/aligner.h"
#include "cf/deliver/run_record.h"

namespace cf {

/// Says it, now and in the report; there with what can be done about it.
void warn(RunRecord& record, const std::string& line, const std::string& advice = {});

/// Enters the final map into what is told of the photos and UAVs, and warns of what is wrong with
/// it.
void judge(const Alignment& alignment, RunRecord& record);

}  // namespace cf
