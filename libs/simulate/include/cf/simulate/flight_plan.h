// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "cf/base/options.h"
#include "cf/simulate/photographer.h"

namespace cf {

/// [flight], and any key of it in [uav.NAME]. Metres in the world's ENU frame.
struct FlightOptions {
  std::string pattern = "lawnmower";  ///< lawnmower | double
  double center_e_m = 0, center_n_m = 0;
  double length_m = 120;  ///< along the strips
  double width_m = 80;    ///< across them
  double heading_deg = 0;
  double height_m = 60;
  double forward_overlap = 0.75, side_overlap = 0.65;
  double speed_mps = 8;
  double photo_interval_s = 0;  ///< 0 = from the overlap
  double start_delay_s = 0;
  std::string mount = "gimbal";  ///< gimbal | fixed
  double turn_radius_m = 12;
  bool photos_in_turns = false;
  std::string gaps;  ///< "T0:T1, T2:T3" [s] from the start
  double wobble_sigma_deg = 0.7, wobble_time_s = 1.5;
  double drift_sigma_m = 0.4, drift_time_s = 8;
  double wind_speed_mps = 0, wind_from_deg = 270;
  bool attitude_tags = false;
  double attitude_sigma_deg = 1;

  void visit(OptionVisitor& v);
};

/// What a photo shows of flat ground from the planned height, photo's top along the flight [m].
struct Footprint {
  double along_m = 0;
  double across_m = 0;
};

/// Times [s] "T0:T1, T2:T3"; throws UsageError that begins with `what`.
std::vector<std::pair<double, double>> intervalsFromText(const std::string& text,
                                                         const std::string& what);
/// Whether a time lies in one of them, ends included.
bool inAnyInterval(const std::vector<std::pair<double, double>>& intervals, double t_s);

/// The share of UAV k of n in an area: slabs side by side across the strips, each wider by
/// `shared_m` where it has a neighbour.
FlightOptions shareOf(const FlightOptions& whole, int k, int n, double shared_m);

/// One UAV's motion over continuous time [s] since its start: straight strips joined by the
/// shortest turns (Dubins 1957), flown at constant ground speed, disturbed by band-limited random
/// processes. A gimbal holds the camera at nadir, photo's top along the course; a fixed camera
/// banks with the turns and points where the nose does, into the wind. Smooth, so that velocities
/// are those of the poses.
class Flight {
 public:
  /// Heights count from `ground_z_m`. Throws UsageError naming `what` where the area is too small
  /// for two photos.
  Flight(const FlightOptions& options, const Footprint& footprint, double ground_z_m,
         std::uint64_t seed, const std::string& what);
  ~Flight();
  Flight(Flight&&) noexcept;

  double duration_s() const;
  /// When photos are taken, whole microseconds, increasing.
  const std::vector<double>& photoTimes() const;
  Eigen::Isometry3d T_world_cam(double t_s) const;
  /// Body: x forward, y left, z up. Its origin is the camera's.
  Eigen::Isometry3d T_world_body(double t_s) const;
  CameraMotion motionAt(double t_s) const;
  std::size_t strips() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cf
