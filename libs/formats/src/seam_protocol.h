// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "cf/types/ids.h"
#include "cf/types/keyframe.h"

namespace cf {

/// Grows with every change that an older reader would not understand.
inline constexpr std::uint32_t kSeamProtocol = 3;

using SegmentsById = std::map<SegmentId, const GeoSegment*>;

/// Of those that may not be there at all.
inline SegmentsById byId(const std::vector<GeoSegment>* segments) {
  SegmentsById out;
  if (segments != nullptr)
    for (const GeoSegment& segment : *segments) out[segment.id] = &segment;
  return out;
}

/// Null if it is not among them.
inline const GeoSegment* segmentIn(const SegmentsById& segments, SegmentId id) {
  const auto it = segments.find(id);
  return it == segments.end() ? nullptr : it->second;
}

}  // namespace cf
