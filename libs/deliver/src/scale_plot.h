// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "cf/deliver/run_record.h"

namespace cf {

/// An inline SVG: the scale of each UAV over time, off its segment's last value in percent.
/// Empty if there is nothing to plot.
std::string scalePlot(const RunRecord& run);

}  // namespace cf
