// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>

#include "scene_plan.h"

namespace cf {

/// What happened to a town since it was planned ([scene] changes, docs/simulate.md). Places are
/// east and north in the world; `middle` is that of the scene's area. Throws UsageError on what
/// cannot be understood, and where no building stands.
void applyChanges(const std::string& changes, const Eigen::Vector2d& middle, TownPlan& plan);

}  // namespace cf
