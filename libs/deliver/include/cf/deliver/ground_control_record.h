// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace cf {

/// A surveyed point as the photos of the final map see it.
struct GroundPointRecord {
  std::string name;
  int marks = 0, uavs = 0;
  double rms_px = 0, max_px = 0;                           ///< of its marks
  Eigen::Vector3d surveyed_m = Eigen::Vector3d::Zero();    ///< world
  Eigen::Vector3d difference_m = Eigen::Vector3d::Zero();  ///< triangulated minus surveyed
  /// As control: the same, if the map had been moved by the other points alone.
  std::optional<Eigen::Vector3d> left_out_m;
};

/// How control points have moved the map.
struct MapMotion {
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();  ///< of the points' centroid
  double rotation_deg = 0, scale = 1;
};

struct GroundControlRecord {
  std::string file;
  std::vector<GroundPointRecord> points;
  std::map<std::string, std::string> missing;  ///< points without a place: why
  std::optional<MapMotion> moved;              ///< none: the points were check points
};

}  // namespace cf
