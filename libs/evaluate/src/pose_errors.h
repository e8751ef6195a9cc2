// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "cf/evaluate/trajectory.h"
#include "figures.h"

namespace cf {

/// Errors of the estimates moved by `S_ref_est`; there must be a pair.
PoseErrors poseErrors(const std::vector<PosePair>& pairs, const Sim3& S_ref_est);

Json jsonOf(const PoseErrors& errors);

}  // namespace cf
