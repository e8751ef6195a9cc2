// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "cf/evaluate/trajectory.h"
#include "figures.h"

namespace cf {

/// In axes turned by R.
std::optional<PoseCovariance> turned(const std::optional<PoseCovariance>& covariance,
                                     const Eigen::Matrix3d& R);

/// Normalised squared errors (NEES) of the poses as they are, under their covariances in the world.
/// null where none has one.
Json worldConsistency(const std::vector<PosePair>& pairs);

/// The same of how they lie to each other: each component is fitted to the reference by one
/// similarity, and what is left stands under the covariances in the map. null where none can be.
Json mapConsistency(const std::vector<PosePair>& pairs);

}  // namespace cf
