// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "marked_points.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <cmath>
#include <map>
#include <set>

#include "cf/base/error.h"
#include "cf/formats/camera_ini.h"
#include "cf/geodesy/crs.h"
#include "cf/geometry/triangulation.h"
#include "estimated_poses.h"
#include "world_origin.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

Eigen::Vector3d surveyedPosition(const LocalFrame& world, const Crs& crs,
                                 const GroundControlPoint& point) {
  const Result<Geodetic> p = geodeticFrom(crs, point.surveyed);
  if (!p) throw UsageError(fmt::format("ground point {}: {}", point.name, p.failure().detail));
  return world.toEnu(*p);
}

CameraModel scaledTo(const PhotoSize& size, const CameraModel& camera, const std::string& uav) {
  const double x = static_cast<double>(size.width) / camera.width;
  const double y = static_cast<double>(size.height) / camera.height;
  constexpr double kSameShape = 0.01;
  if (std::abs(x / y - 1) > kSameShape)
    throw RunError(fmt::format("photos of {}x{} are not those of {}, {}x{}, in another size",
                               size.width, size.height, uav, camera.width, camera.height));
  return camera.scaled(size.width, size.height);
}

/// The refined cameras of a run, as they would be in photos of the list's size.
class Cameras {
 public:
  Cameras(fs::path folder, std::optional<PhotoSize> size)
      : folder_(std::move(folder)), size_(size) {}

  const CameraModel& of(const std::string& uav) {
    const auto known = cameras_.find(uav);
    if (known != cameras_.end()) return known->second;
    CameraModel camera;
    try {
      camera = readCameraIni(folder_ / (uav + ".ini"));
    } catch (const UsageError& e) {
      throw RunError(e.what());
    }
    if (size_) camera = scaledTo(*size_, camera, uav);
    return cameras_.emplace(uav, camera).first->second;
  }

 private:
  fs::path folder_;
  std::optional<PhotoSize> size_;
  std::map<std::string, CameraModel> cameras_;
};

/// The pose of the marked photo, if it has one.
const EstimatedPose* poseOf(const EstimatedPoses& poses, const std::string& image) {
  const fs::path path = image;
  const std::string uav = path.parent_path().filename().string();
  const auto [first, last] = poses.equal_range(path.filename().string());
  const EstimatedPose* found = nullptr;
  for (auto it = first; it != last; ++it) {
    if (!uav.empty() && it->second.uav != uav) continue;
    if (found != nullptr)
      throw UsageError(
          fmt::format("the list's photo {0} is one of {1} and of {2}: call it {1}/{0} "
                      "or {2}/{0}",
                      path.filename().string(), found->uav, it->second.uav));
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

std::vector<MarkedPoint> joinMarks(const fs::path& out_dir, const GcpList& list,
                                   std::optional<PhotoSize> size) {
  const Result<Crs> crs = crsFromText(list.crs);
  if (!crs) throw UsageError("ground points: " + crs.failure().detail);
  const EstimatedPoses poses = readEstimatedPoses(out_dir);
  const std::optional<LocalFrame> world = worldFrameOf(out_dir);
  if (!world)
    throw RunError((out_dir / "world.json").string() +
                   ": gives no origin: the map's place on the earth is not known");
  Cameras cameras(out_dir / "cameras", size);
  std::vector<MarkedPoint> points;
  for (const GroundControlPoint& listed : list.points) {
    MarkedPoint point;
    point.name = listed.name;
    point.surveyed = surveyedPosition(*world, *crs, listed);
    for (const GcpMark& mark : listed.marks) {
      const EstimatedPose* pose = poseOf(poses, mark.image);
      if (pose == nullptr) {
        point.without_pose.push_back(mark.image);
        continue;
      }
      const CameraModel& camera = cameras.of(pose->uav);
      if (!camera.contains(mark.pixel))
        throw RunError(fmt::format(
            "ground point {} is marked at {}, {} in {}, a photo of {}x{}: tell the size of the "
            "photos that the list was made with (--size)",
            listed.name, mark.pixel.x(), mark.pixel.y(), mark.image, camera.width, camera.height));
      point.sights.push_back({pose->uav, mark.image, mark.pixel, pose->T_world_cam, camera});
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
