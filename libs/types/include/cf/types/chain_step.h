// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cf/types/ids.h"
#include "cf/types/keyframe.h"

namespace cf {

/// What a UAV hands over the seam when one of its photos has been processed, or at the end.
struct ChainStep {
  std::uint16_t uav = 0;
  std::vector<GeoKeyframe> keyframes;  ///< that became final
  /// All of the UAV's segments as it knows them alone, those of its newest keyframe last. None
  /// after a damaged photo: as before.
  std::shared_ptr<const std::vector<GeoSegment>> segments;
  GnssQuality gnss;
  /// A photo before it is final: its segment and pose there, as known now.
  struct Provisional {
    FrameId photo;
    int segment = 0;
    Eigen::Isometry3d T_local_cam = Eigen::Isometry3d::Identity();
    std::optional<Eigen::Isometry3d> T_world_cam;  ///< as the UAV knows it alone
  };
  /// All that are not final, the photo processed last. None if that is damaged, and at the end.
  std::vector<Provisional> provisional;
  std::string jpeg;  ///< the photo itself, at the size that dense matching needs
};

}  // namespace cf
