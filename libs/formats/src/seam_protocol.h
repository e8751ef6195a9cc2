// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "cf/types/keyframe.h"

namespace cf {

/// Grows with every change that an older reader would not understand.
inline constexpr std::uint32_t kSeamProtocol = 1;

/// Null if it is not among them.
inline const GeoSegment* segmentIn(const std::vector<GeoSegment>* segments, SegmentId id) {
  if (segments == nullptr) return nullptr;
  const auto it = std::find_if(segments->begin(), segments->end(),
                               [&](const GeoSegment& segment) { return segment.id == id; });
  return it == segments->end() ? nullptr : &*it;
}

}  // namespace cf
