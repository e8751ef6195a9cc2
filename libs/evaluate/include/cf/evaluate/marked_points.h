// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cf/base/result.h"
#include "cf/evaluate/ground_control.h"
#include "cf/formats/gcp_list.h"
#include "cf/geodesy/local_frame.h"
#include "cf/types/camera_model.h"

namespace cf {

/// A photo of the map, as marks in it are seen.
struct MapPhoto {
  std::string uav;
  Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
  CameraModel camera;  ///< refined
};
/// By name, which several UAVs may use.
using MapPhotos = std::multimap<std::string, MapPhoto>;

/// A mark in a photo with a pose.
struct MarkedSight {
  std::string uav, image;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< as marked
  Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
  CameraModel camera;  ///< for photos of the size in which it was marked

  /// Where the camera sees the point, minus the mark [px].
  Eigen::Vector2d errorOf(const Eigen::Vector3d& p_world) const;
};

struct MarkedPoint {
  std::string name;
  Eigen::Vector3d surveyed = Eigen::Vector3d::Zero();  ///< ENU of the map's world [m]
  std::vector<MarkedSight> sights;
  std::vector<std::string> without_pose;  ///< photos with a mark, but no pose in the map

  int uavs() const;
};

/// Where the list's points are on earth, in its order. Throws UsageError where it has an unknown
/// CRS or a position that is no place.
std::vector<Geodetic> surveyedPlaces(const GcpList& list);

/// The list's points in the map's world, with its poses and cameras. `size` of the photos in which
/// they were marked, if not the map's. Throws RunError where a mark does not fit its photo,
/// UsageError as surveyedPlaces() and where the list has a photo's name that several UAVs have.
std::vector<MarkedPoint> joinMarks(const GcpList& list, const LocalFrame& world,
                                   const MapPhotos& photos, std::optional<PhotoSize> size);

struct MarkedPlace {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< world
  double max_angle_rad = 0;                            ///< largest between two rays
};

/// The place of the least sum of squared pixel errors; fails as triangulate() does.
Result<MarkedPlace> placeOf(const std::vector<MarkedSight>& sights);

}  // namespace cf
