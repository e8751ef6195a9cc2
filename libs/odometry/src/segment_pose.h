// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "cf/base/result.h"
#include "cf/geometry/two_view.h"
#include "local_map.h"

namespace cf {

/// Matches of one photo (b) with others (a), by the other.
using MatchesByPhoto = std::map<PhotoIndex, std::vector<FeatureMatch>>;

/// When a photo counts as posed.
struct PoseLimits {
  double threshold = 0;  ///< inlier distance on the normalized plane
  int min_inliers = 0;
};

/// Two-view geometry of two photos from their matches: T_a_b up to its length.
Result<TwoView> twoViewOf(const TrackedPhoto& a, const TrackedPhoto& b,
                          const std::vector<FeatureMatch>& matches, const PoseLimits& limits);

/// T_local_cam of a photo in a segment, by resection on the landmarks that its matches with the
/// segment's photos see. Where these are too few, or too close together to hold a pose: two-view
/// geometry with the photo of the segment that has most matches, and the landmarks for the length
/// of the baseline. None where neither is to be had.
std::optional<Eigen::Isometry3d> poseInSegment(const LocalMap& map, int segment,
                                               const TrackedPhoto& target,
                                               const MatchesByPhoto& matches,
                                               const PoseLimits& limits);

/// The same where posed photo `last` shares ground with the target but no landmark (half a photo of
/// overlap, or a little more): two-view geometry, and the ground under `last` for the length of the
/// baseline: one plane through its landmarks on the one half and what both see on the other. None
/// where that would be a guess.
std::optional<Eigen::Isometry3d> poseOverGround(const LocalMap& map, PhotoIndex last,
                                                const TrackedPhoto& target,
                                                const std::vector<FeatureMatch>& matches,
                                                const PoseLimits& limits);

}  // namespace cf
