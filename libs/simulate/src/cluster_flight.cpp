// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cluster_flight.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "cf/base/error.h"
#include "random_stream.h"

namespace cf {
namespace {

constexpr double kDegrees = 180 / M_PI;

std::string sectionOf(const SimulatedUavOptions& uav) { return fmt::format("[uav.{}] ", uav.name); }

Footprint footprintOf(const SimulatedUavOptions& uav) {
  const TrueCamera c = uav.lens.trueCamera();
  const double gsd = uav.flight.height_m / c.focal;
  return {c.height * gsd, c.width * gsd};
}

std::uint64_t seedOf(const SimulationSetup& setup, const SimulatedUavOptions& uav,
                     const std::string& purpose) {
  return streamSeed(static_cast<std::uint64_t>(setup.simulation.seed), uav.name + "/" + purpose);
}

Flight flightOf(const SimulationSetup& setup, const SimulatedUavOptions& uav, double ground_z) {
  return Flight(uav.flight, footprintOf(uav), ground_z, seedOf(setup, uav, "flight"),
                sectionOf(uav));
}

/// How far from a photo's foot it can show the ground.
double reachOf(const CameraMotion& motion, const TrueCamera& camera, double height) {
  constexpr double kFarthest = 4;  // in heights: a camera may look above the horizon
  double reach = 0;
  for (const int x : {0, camera.width - 1})
    for (const int y : {0, camera.height - 1}) {
      const Eigen::Vector3d ray =
          motion.T_world_cam.linear() * camera.rayThrough(Eigen::Vector2d(x, y));
      const double tangent = ray.z() < 0 ? ray.head<2>().norm() / -ray.z() : kFarthest;
      reach = std::max(reach, height * std::min(tangent, kFarthest));
    }
  return reach;
}

/// What a gimbal tags: the inverse of rotationWorldCam. Straight down, yaw and roll are one angle,
/// and all of it goes to yaw.
GimbalAttitude attitudeOf(const Eigen::Matrix3d& R_world_cam) {
  constexpr double kStraightDown = 1e-9;
  const Eigen::Vector3d axis = R_world_cam.col(2), right = R_world_cam.col(0);
  GimbalAttitude a;
  a.pitch_deg = std::asin(std::clamp(axis.z(), -1.0, 1.0)) * kDegrees;
  a.roll_deg = 0;
  if (axis.head<2>().norm() < kStraightDown) {
    a.yaw_deg = std::atan2(-right.y(), right.x()) * kDegrees;
    return a;
  }
  a.yaw_deg = std::atan2(axis.x(), axis.y()) * kDegrees;
  const Eigen::Matrix3d unrolled = rotationWorldCam(a);
  const Eigen::Matrix3d rest = unrolled.transpose() * R_world_cam;  // about the optical axis
  a.roll_deg = std::atan2(rest(1, 0), rest(0, 0)) * kDegrees;
  return a;
}

Eigen::AlignedBox2d areaFrom(const std::string& text) {
  constexpr double kMost_m = 1e5;
  double west = 0, south = 0, east = 0, north = 0;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%lf , %lf , %lf , %lf %c", &west, &south, &east, &north, &rest) !=
          4 ||
      !(west < east) || !(south < north) || !(west >= -kMost_m) || !(south >= -kMost_m) ||
      !(east <= kMost_m) || !(north <= kMost_m))
    throw UsageError("[scene] area = " + text +
                     ": give the west, south, east and north of it [m], as in -80, -60, 80, 60");
  return {Eigen::Vector2d(west, south), Eigen::Vector2d(east, north)};
}

std::vector<PlannedPhoto> photosOf(const SimulationSetup& setup, const SimulatedUavOptions& uav,
                                   const Flight& flight, TimeNs start) {
  RandomStream tags(seedOf(setup, uav, "attitude"));
  const std::uint64_t light = seedOf(setup, uav, "photo");
  std::vector<PlannedPhoto> photos;
  for (const double t : flight.photoTimes()) {
    PlannedPhoto photo;
    photo.name = fmt::format("{}_{:04}.jpg", uav.name, photos.size() + 1);
    photo.time = start + std::llround(t * 1e6) * 1000;
    photo.motion = flight.motionAt(t);
    photo.seed = streamSeed(light, photo.name);
    if (uav.flight.attitude_tags) {
      GimbalAttitude a = attitudeOf(photo.motion.T_world_cam.linear());
      a.yaw_deg += uav.flight.attitude_sigma_deg * tags.normal();
      a.pitch_deg += uav.flight.attitude_sigma_deg * tags.normal();
      a.roll_deg += uav.flight.attitude_sigma_deg * tags.normal();
      photo.attitude = a;
    }
    photos.push_back(photo);
  }
  return photos;
}

void requireClearance(const PlannedUav& uav, const Scene& scene) {
  constexpr double kClearance_m = 2;
  for (const PlannedPhoto& photo : uav.photos) {
    const Eigen::Vector3d p = photo.motion.T_world_cam.translation();
    const double below = scene.surfaceHeight(p.x(), p.y());
    if (p.z() < below + kClearance_m)
      throw UsageError(fmt::format(
          "{}height = {} is too low: at photo {} the UAV is {:.1f} m above what stands there",
          sectionOf(uav.options), uav.options.flight.height_m, photo.name, p.z() - below));
  }
}

}  // namespace

Eigen::AlignedBox2d areaOf(const SimulationSetup& setup) {
  constexpr double kMargin = 1.1;
  Eigen::AlignedBox2d area;
  for (const SimulatedUavOptions& uav : setup.uavs) {
    const Flight flight = flightOf(setup, uav, 0);
    const TrueCamera camera = uav.lens.trueCamera();
    for (const double t : flight.photoTimes()) {
      const CameraMotion motion = flight.motionAt(t);
      const double reach =
          kMargin * reachOf(motion, camera, uav.flight.height_m + setup.scene.relief_m);
      const Eigen::Vector2d foot = motion.T_world_cam.translation().head<2>();
      area.extend(Eigen::Vector2d(foot.array() - reach));
      area.extend(Eigen::Vector2d(foot.array() + reach));
    }
  }
  if (setup.scene.area.empty()) return area;
  const Eigen::AlignedBox2d given = areaFrom(setup.scene.area);
  if (!given.contains(area))
    throw UsageError(fmt::format(
        "[scene] area = {}: the photos may see {:.0f}, {:.0f}, {:.0f}, {:.0f}, which it must hold",
        setup.scene.area, std::floor(area.min().x()), std::floor(area.min().y()),
        std::ceil(area.max().x()), std::ceil(area.max().y())));
  return given;
}

std::vector<PlannedUav> planCluster(const SimulationSetup& setup, const Scene& scene,
                                    const LocalFrame& world) {
  std::vector<PlannedUav> uavs;
  for (const SimulatedUavOptions& options : setup.uavs) {
    PlannedUav uav;
    uav.options = options;
    uav.camera = options.lens.trueCamera();
    uav.told = options.lens.toldCamera();
    uav.footprint = footprintOf(options);
    uav.ground_z_m = scene.groundHeight(options.flight.center_e_m, options.flight.center_n_m);
    const TimeNs start = setup.start + std::llround(options.flight.start_delay_s * 1e6) * 1000;
    const Flight flight = flightOf(setup, options, uav.ground_z_m);
    uav.strips = flight.strips();
    uav.duration_s = flight.duration_s();
    uav.photos = photosOf(setup, options, flight, start);
    uav.gnss = simulateGnss(options.gnss, flight, start, world, seedOf(setup, options, "gnss"),
                            sectionOf(options));
    requireClearance(uav, scene);
    uavs.push_back(std::move(uav));
  }
  return uavs;
}

}  // namespace cf
