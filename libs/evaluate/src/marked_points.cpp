// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/evaluate/marked_points.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <cmath>
#include <filesystem>
#include <set>

#include "cf/base/error.h"
#include "cf/geodesy/crs.h"
#include "cf/geometry/triangulation.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

CameraModel scaledTo(const PhotoSize& size, const CameraModel& camera, const std::string& uav) {
  const double x = static_cast<double>(size.width) / camera.width;
  const double y = static_cast<double>(size.height) / camera.height;
  constexpr double kSameShape = 0.01;
  if (std::abs(x / y - 1) > kSameShape)
    throw RunError(fmt::format("photos of {}x{} are not those of {}, {}x{}, in another size",
                               size.width, size.height, uav, camera.width, camera.height));
  return camera.scaled(size.width, size.height);
}

/// The marked photo, if it has a pose.
const MapPhoto* photoOf(const MapPhotos& photos, const std::string& image, const GcpList& list) {
  const fs::path path = image;
  const std::string uav = path.parent_path().filename().string();
  const auto [first, last] = photos.equal_range(path.filename().string());
  const MapPhoto* found = nullptr;
  for (auto it = first; it != last; ++it) {
    if (!uav.empty() && it->second.uav != uav) continue;
    if (found != nullptr)
      throw UsageError(
          fmt::format("{0}: the photo {1} is one of {2} and of {3}: call it {2}/{1} or {3}/{1}",
                      list.file.string(), path.filename().string(), found->uav, it->second.uav));
    found = &it->second;
  }
  return found;
}

}  // namespace

Eigen::Vector2d MarkedSight::errorOf(const Eigen::Vector3d& p_world) const {
  return camera.project(T_world_cam.inverse() * p_world) - pixel;
}

int MarkedPoint::uavs() const {
  std::set<std::string> names;
  for (const MarkedSight& sight : sights) names.insert(sight.uav);
  return static_cast<int>(names.size());
}

std::vector<Geodetic> surveyedPlaces(const GcpList& list) {
  const Result<Crs> crs = crsFromText(list.crs);
  if (!crs) throw UsageError(fmt::format("{}: {}", list.file.string(), crs.failure().detail));
  std::vector<Geodetic> places;
  for (const GroundControlPoint& point : list.points) {
    const Result<Geodetic> place = geodeticFrom(*crs, point.surveyed);
    if (!place)
      throw UsageError(fmt::format("{}: ground point {}: {}", list.file.string(), point.name,
                                   place.failure().detail));
    places.push_back(*place);
  }
  return places;
}

std::vector<MarkedPoint> joinMarks(const GcpList& list, const LocalFrame& world,
                                   const MapPhotos& photos, std::optional<PhotoSize> size) {
  const std::vector<Geodetic> places = surveyedPlaces(list);
  std::vector<MarkedPoint> points;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const GroundControlPoint& listed = list.points[i];
    MarkedPoint point;
    point.name = listed.name;
    point.surveyed = world.toEnu(places[i]);
    for (const GcpMark& mark : listed.marks) {
      const MapPhoto* photo = photoOf(photos, mark.image, list);
      if (photo == nullptr) {
        point.without_pose.push_back(mark.image);
        continue;
      }
      const CameraModel camera = size ? scaledTo(*size, photo->camera, photo->uav) : photo->camera;
      if (!camera.contains(mark.pixel))
        throw RunError(fmt::format(
            "{}: ground point {} is marked at {}, {} in {}, a photo of {}x{}: tell the size of the "
            "photos that the list was made with (cf-eval --size, cf-run [gcp] size)",
            list.file.string(), listed.name, mark.pixel.x(), mark.pixel.y(), mark.image,
            camera.width, camera.height));
      point.sights.push_back({photo->uav, mark.image, mark.pixel, photo->T_world_cam, camera});
    }
    points.push_back(std::move(point));
  }
  return points;
}

Result<MarkedPlace> placeOf(const std::vector<MarkedSight>& sights) {
  std::vector<Sight> rays;
  for (const MarkedSight& s : sights) rays.push_back({s.T_world_cam, s.camera.undistort(s.pixel)});
  const Result<Triangulated> start = triangulate(rays);
  if (!start) return start.failure();
  Eigen::Vector3d p = start->position;
  // Gauss-Newton on the pixels: cameras may differ in focal length, and distortion counts.
  constexpr int kRounds = 10;
  constexpr double kStep_m = 1e-3, kSmall_m = 1e-9;
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix3d N = Eigen::Matrix3d::Zero();
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
    for (const MarkedSight& s : sights) {
      Eigen::Matrix<double, 2, 3> J;
      for (int axis = 0; axis < 3; ++axis) {
        const Eigen::Vector3d step = kStep_m * Eigen::Vector3d::Unit(axis);
        J.col(axis) = (s.errorOf(p + step) - s.errorOf(p - step)) / (2 * kStep_m);
      }
      N += J.transpose() * J;
      g += J.transpose() * s.errorOf(p);
    }
    const Eigen::Vector3d step = N.ldlt().solve(g);
    if (!step.allFinite()) return Failure{"parallel", "the rays are parallel"};
    p -= step;
    if (step.norm() < kSmall_m) break;
  }
  return MarkedPlace{p, start->max_angle_rad};
}

}  // namespace cf
