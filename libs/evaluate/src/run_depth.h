// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "run_section.h"
#include "truth_views.h"

namespace cf {

/// The run's depth maps (depth/<uav>/<photo>.tif) against the true ones at the same pixels, as they
/// are and multiplied by the cluster's `scale`; and how much of what two photos see has a depth.
RunSection depthFigures(const RunInputs& run, const std::vector<TruthView>& views, double scale);

}  // namespace cf
