// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "cf/georeference/georeferencer.h"
#include "cf/types/sim3.h"

namespace cf::test {

/// A fix as if its latitude, longitude and height were world coordinates in metres.
inline Eigen::Vector3d metresAsDegrees(const GnssFix& fix) {
  return {fix.longitude_deg, fix.latitude_deg, fix.height_m};
}

inline Eigen::Matrix3d rotationOf(const Eigen::Vector3d& v) {
  return v.norm() < 1e-15 ? Eigen::Matrix3d(Eigen::Matrix3d::Identity())
                          : Eigen::AngleAxisd(v.norm(), v.normalized()).toRotationMatrix();
}

inline Eigen::Vector3d rotationVector(const Eigen::Matrix3d& R) {
  const Eigen::AngleAxisd a(R);
  return a.angle() * a.axis();
}

/// One simulated flight: exact truth, odometry in an arbitrary frame and scale, fixes.
struct Flight {
  std::vector<Eigen::Isometry3d> T_world_cam;  ///< truth
  std::vector<std::shared_ptr<Keyframe>> keyframes;
  std::vector<GnssFix> fixes;
  double scale = 8;  ///< true metres per VO unit

  std::mt19937 random{1};
  double normal(double sigma) { return std::normal_distribution<double>(0, sigma)(random); }
  Eigen::Vector3d normal3(double sigma) { return {normal(sigma), normal(sigma), normal(sigma)}; }
};

struct FlightPlan {
  int lines = 4, per_line = 12;
  double step_m = 10, spacing_m = 25, height_m = 60, interval_s = 4;
  double pitch_deg = 0;     ///< camera forward of nadir
  double attitude_deg = 2;  ///< jitter of each photo
  double tilt_deg = 0;      ///< common to all photos, drawn
  double vo_rotation_deg = 0.1, vo_step = 0.01, vo_depth = 0.001;
  Eigen::Vector3d sigma_m = {1.5, 1.5, 3};
  Eigen::Vector3d tagged_m = {1.5, 1.5, 3};
  bool gimbal = false, points = false;
};

/// Features of flat ground at z = 0 on a grid of the photo, with their exact inverse depths.
inline void addGround(Keyframe& keyframe, const Eigen::Isometry3d& T_world_cam, double scale,
                      Flight& flight) {
  auto features = std::make_shared<FeatureSet>();
  for (int x = 50; x < 1000; x += 100)
    for (int y = 50; y < 750; y += 100) {
      const Eigen::Vector2d pixel(x, y);
      const Eigen::Vector3d ray =
          T_world_cam.linear() * keyframe.camera.undistort(pixel).homogeneous();
      if (ray.z() > -0.1) continue;
      const double depth_m = -T_world_cam.translation().z() / ray.z() + flight.normal(0.3);
      features->pixel.push_back(pixel.cast<float>());
      keyframe.inverse_depth.push_back(static_cast<float>(scale / depth_m));
    }
  keyframe.features = features;
}

inline Flight fly(const FlightPlan& plan, unsigned seed) {
  Flight flight;
  flight.random.seed(seed);
  const Eigen::Vector3d common = flight.normal3(plan.tilt_deg * M_PI / 180);
  for (int line = 0; line < plan.lines; ++line)
    for (int k = 0; k < plan.per_line; ++k) {
      const bool back = line % 2 == 1;
      const double heading = back ? M_PI : 0;  // flown east and west
      Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
      T.translation() << plan.step_m * (back ? plan.per_line - 1 - k : k), plan.spacing_m * line,
          plan.height_m;
      T.translation() += flight.normal3(0.5);
      Eigen::Matrix3d nadir;  // the photo's top is east
      nadir << 0, -1, 0, -1, 0, 0, 0, 0, -1;
      T.linear() = rotationOf({common.x(), common.y(), 0}) * rotationOf({0, 0, heading}) *
                   rotationOf(flight.normal3(plan.attitude_deg * M_PI / 180)) * nadir *
                   rotationOf({plan.pitch_deg * M_PI / 180, 0, 0});
      flight.T_world_cam.push_back(T);
    }

  Eigen::Isometry3d T_local_cam = Eigen::Isometry3d::Identity();
  T_local_cam.linear() = rotationOf(flight.normal3(1.5));
  T_local_cam.translation() = flight.normal3(3);
  for (std::size_t i = 0; i < flight.T_world_cam.size(); ++i) {
    if (i > 0) {
      Eigen::Isometry3d T_i_j = flight.T_world_cam[i - 1].inverse() * flight.T_world_cam[i];
      const double sigma = plan.vo_step * T_i_j.translation().norm() +
                           (plan.points ? plan.vo_depth * plan.height_m : 0);
      T_i_j.translation() = (T_i_j.translation() + flight.normal3(sigma)) / flight.scale;
      T_i_j.linear() =
          T_i_j.linear() * rotationOf(flight.normal3(plan.vo_rotation_deg * M_PI / 180));
      T_local_cam = T_local_cam * T_i_j;
    }
    auto keyframe = std::make_shared<Keyframe>();
    keyframe->id = {0, static_cast<std::uint32_t>(i)};
    keyframe->time =
        1'000 * kNsPerSecond + static_cast<TimeNs>(static_cast<double>(i) * plan.interval_s * 1e9);
    keyframe->T_local_cam = T_local_cam;
    keyframe->camera.width = 1000;
    keyframe->camera.height = 750;
    keyframe->camera.fx = keyframe->camera.fy = 800;
    keyframe->camera.cx = 499.5;
    keyframe->camera.cy = 374.5;
    if (plan.points) addGround(*keyframe, flight.T_world_cam[i], flight.scale, flight);
    if (plan.gimbal) {
      // The tag describes a level camera of this heading: what the gimbal was told.
      const Eigen::Vector3d up = flight.T_world_cam[i].linear().col(1) * -1;
      keyframe->attitude =
          GimbalAttitude{std::atan2(up.x(), up.y()) * 180 / M_PI, -90 + plan.pitch_deg, 0};
    }
    flight.keyframes.push_back(keyframe);
    const Eigen::Vector3d p =
        flight.T_world_cam[i].translation() + plan.sigma_m.cwiseProduct(flight.normal3(1));
    GnssFix fix;
    fix.time = keyframe->time;
    fix.longitude_deg = p.x();
    fix.latitude_deg = p.y();
    fix.height_m = p.z();
    fix.sigma_enu_m = plan.tagged_m;
    flight.fixes.push_back(fix);
  }
  return flight;
}

inline Georeferencer run(const Flight& flight, const GeoreferenceOptions& options = {}) {
  Georeferencer stage(0, options, metresAsDegrees);
  for (const GnssFix& fix : flight.fixes) stage.addFix(fix);
  for (const auto& keyframe : flight.keyframes) stage.push(keyframe);
  stage.flush();
  return stage;
}

/// Errors of one estimated pose in the order of its covariance.
inline Eigen::Matrix<double, 6, 1> errorOf(const GeoSegment::Pose& pose,
                                           const Eigen::Isometry3d& truth) {
  Eigen::Matrix<double, 6, 1> e;
  e << pose.T_world_cam.translation() - truth.translation(),
      rotationVector(pose.T_world_cam.linear() * truth.linear().transpose());
  return e;
}

}  // namespace cf::test
