// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "run_inputs.h"
#include "run_section.h"

namespace cf {

/// The scale of Umeyama's similarity between pairs (true position [m], local position [VO units]).
/// It is determined for points on one line too. 0 where the local ones coincide.
double umeyamaScale(const std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>>& pairs);

/// Scale of each segment over time, and of the final poses, against the truth.
RunSection scaleFigures(const RunInputs& run);

}  // namespace cf
