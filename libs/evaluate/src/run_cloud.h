// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "cf/types/sim3.h"
#include "run_section.h"
#include "truth_views.h"

namespace cf {

/// Ground size of a matched pixel [m]: the median over the photos of the true depths.
std::optional<double> matchedGroundSize(const RunInputs& run, const std::vector<TruthView>& views);

/// The run's cloud, moved by the cluster's similarity, against truth/cloud.ply, truth/dsm.tif and
/// what the photos of the truth see.
RunSection cloudFigures(const RunInputs& run, const std::vector<TruthView>& views,
                        const Sim3& S_ref_est, std::optional<double> matched_size_m);

}  // namespace cf
