// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "cf/densify/densify.h"
#include "cf/types/pose_table.h"

namespace cf {

/// Two photos to be matched densely, with poses and cameras of one version of the map.
struct StereoPair {
  DenseView reference, partner;
};

/// The photos of a version of the map that have depth, by id.
std::vector<DenseView> denseViews(const PoseTable& table);

/// Ground size of a matched pixel [m], the median over the views.
double matchedGroundSize(const std::vector<DenseView>& views, double megapixels);

/// The pairs that the views choose: each photo, as reference, with up to options.partners; a pair
/// that both choose comes once, from the first.
std::vector<StereoPair> stereoPairs(const std::vector<DenseView>& views,
                                    const DensifyOptions& options);

}  // namespace cf
