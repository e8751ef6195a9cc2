// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "cf/types/feature_set.h"

namespace cf {

struct MatchOptions {
  double ratio = 0.85;  ///< best distance over second best (Lowe's test), both L2
};

/// Mutual nearest neighbours of the descriptors that pass the ratio test; exhaustive, exact.
std::vector<FeatureMatch> matchFeatures(const FeatureSet& a, const FeatureSet& b,
                                        const MatchOptions& options = {});

/// Where a feature is looked for in the other photo.
struct SearchDisc {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  double radius = -1;  ///< below 0: nowhere
};

/// The same among the pairs that may be: feature i of a is compared with the features of b whose
/// `position_b` lies within `disc_a[i]`, in whatever unit both are. Where much looks alike a place
/// tells apart what descriptors cannot. One candidate alone is no match: nothing tells how good it
/// is.
std::vector<FeatureMatch> matchFeaturesWithin(const FeatureSet& a, const FeatureSet& b,
                                              const std::vector<SearchDisc>& disc_a,
                                              const std::vector<Eigen::Vector2d>& position_b,
                                              const MatchOptions& options = {});

}  // namespace cf
