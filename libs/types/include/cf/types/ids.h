// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace cf {

/// One photo of one UAV. `uav` indexes the UAVs in the order of the configuration, `index` counts
/// the photos of that UAV in time order, damaged ones included.
struct FrameId {
  std::uint16_t uav = 0;
  std::uint32_t index = 0;

  friend bool operator==(FrameId a, FrameId b) { return a.uav == b.uav && a.index == b.index; }
  friend bool operator!=(FrameId a, FrameId b) { return !(a == b); }
  friend bool operator<(FrameId a, FrameId b) {
    return a.uav != b.uav ? a.uav < b.uav : a.index < b.index;
  }
};

/// A stretch of one UAV's odometry in one local frame with one scale. Numbered from 0 per UAV.
struct SegmentId {
  std::uint16_t uav = 0;
  int segment = 0;

  friend bool operator==(SegmentId a, SegmentId b) {
    return a.uav == b.uav && a.segment == b.segment;
  }
  friend bool operator<(SegmentId a, SegmentId b) {
    return a.uav != b.uav ? a.uav < b.uav : a.segment < b.segment;
  }
};

}  // namespace cf
