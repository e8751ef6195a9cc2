// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "cf/types/feature_set.h"

namespace cf {

struct MatchOptions {
  double ratio = 0.85;  ///< best distance over second best (Lowe's test), both L2
};

/// Mutual nearest neighbours of the descriptors that pass the ratio test; exhaustive, exact.
std::vector<FeatureMatch> matchFeatures(const FeatureSet& a, const FeatureSet& b,
                                        const MatchOptions& options = {});

}  // namespace cf
