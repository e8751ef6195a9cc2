// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

namespace cf {

/// Where somebody saw a ground point in a photo.
struct GcpMark {
  std::string image;                                ///< base name of the photo, or `<uav>/<name>`
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< (0,0) is the centre of the top-left pixel
};

/// A surveyed point on the ground.
struct GroundControlPoint {
  std::string name;  ///< as given, otherwise its number in the list, from "1"
  Eigen::Vector3d surveyed = Eigen::Vector3d::Zero();  ///< x y z in the list's CRS
  std::vector<GcpMark> marks;
};

struct GcpList {
  std::filesystem::path file;  ///< that it was read from, for what there is to say about it
  std::string crs;             ///< the first line as it is; crsFromText() of libs/geodesy reads it
  std::vector<GroundControlPoint> points;  ///< in order of their first mark
};

/// Reads the gcp_list.txt of OpenDroneMap: first line the CRS, then lines `x y z px py image
/// [name]`, one for each mark. Marks of one name, or without a name of the same x y z, are of one
/// point. Empty lines and what follows a '#' are skipped. Throws UsageError naming file and line.
GcpList readGcpList(const std::filesystem::path& file);

}  // namespace cf
