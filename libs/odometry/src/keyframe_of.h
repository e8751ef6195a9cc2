// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "local_map.h"

namespace cf {

/// A photo as it is known now, with the inverse depths of all its features.
Keyframe keyframeOf(const LocalMap& map, PhotoIndex i);

/// The features that leave with it, `most` at most: first those that a third photo confirms, then
/// those with a landmark. Within a class they stay in the order in which they are spread.
Keyframe withBestFeatures(Keyframe keyframe, const LocalMap& map, PhotoIndex i, std::size_t most);

}  // namespace cf
