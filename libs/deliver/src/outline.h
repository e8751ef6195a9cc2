// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "cf/deliver/run_record.h"

namespace cf {

/// The corners of the convex hull, seen from above, of the sparse points that at least three photos
/// see, counter-clockwise, world. Points far behind the others (a horizon) do not count. Empty
/// where there are too few of them.
std::vector<Eigen::Vector3d> outlineOf(const RunRecord& run);

}  // namespace cf
