// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/simulate/flight_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "cf/base/error.h"
#include "cf/base/text.h"
#include "flight_path.h"
#include "random_stream.h"

namespace cf {
namespace {

constexpr double kGravity = 9.81;
constexpr double kRollTime_s = 1;  // a wing rolls into and out of a turn within twice this
constexpr double kMicroseconds = 1e6;

using Intervals = std::vector<std::pair<double, double>>;

/// Arc lengths at which photos are taken.
std::vector<double> photoPlaces(const FlightPath& path, double spacing, bool in_turns) {
  std::vector<double> places;
  const auto fill = [&](double begin, double end) {
    const int more = static_cast<int>(std::floor((end - begin) / spacing + 1e-9));
    const double first = (begin + end - more * spacing) / 2;
    for (int i = 0; i <= more; ++i) places.push_back(first + i * spacing);
  };
  if (in_turns)
    fill(path.strips().front().first, path.strips().back().second);
  else
    for (const auto& [begin, end] : path.strips()) fill(begin, end);
  return places;
}

Eigen::Matrix3d turned(double angle, const Eigen::Vector3d& axis) {
  return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
}

}  // namespace

void FlightOptions::visit(OptionVisitor& v) {
  v.choice("pattern", pattern, {"lawnmower", "double"},
           "lawnmower: parallel strips to and fro; double: those, then again at right angles");
  v.number("center_e", center_e_m, {-1e5, 1e5}, "centre of the area, east of the origin [m]");
  v.number("center_n", center_n_m, {-1e5, 1e5}, "centre of the area, north of the origin [m]");
  v.number("length", length_m, {1, 1e5}, "size of the area along the strips [m]");
  v.number("width", width_m, {0.01, 1e5}, "size of the area across the strips [m]");
  v.number("heading", heading_deg, {-360, 360}, "of the first strip, from north clockwise [deg]");
  v.number("height", height_m, {5, 5000}, "above the ground at the centre of the area [m]");
  v.number("forward_overlap", forward_overlap, {0, 0.98},
           "of a photo with the next, fraction; on flat ground");
  v.number("side_overlap", side_overlap, {0, 0.98}, "of a strip with the next, fraction; at least");
  v.number("speed", speed_mps, {0.5, 100}, "over the ground [m/s]");
  v.number("photo_interval", photo_interval_s, {0, 600},
           "time between photos [s]; 0 = from the forward overlap");
  v.number("start_delay", start_delay_s, {0, 1e6}, "after the start of the simulation [s]");
  v.choice("mount", mount, {"gimbal", "fixed"},
           "gimbal: camera held straight down; fixed: it banks with the UAV, and turns into the "
           "wind");
  v.number("turn_radius", turn_radius_m, {1, 1000}, "of the turns between strips [m]");
  v.flag("photos_in_turns", photos_in_turns, "go on taking photos between the strips");
  v.text("gaps", gaps, "T0:T1, T2:T3: no photos at these times after the UAV's start [s]");
  v.number("wobble_sigma", wobble_sigma_deg, {0, 30}, "unrest of the attitude per axis [deg]");
  v.number("wobble_time", wobble_time_s, {0.02, 1000}, "its correlation time [s]");
  v.number("drift_sigma", drift_sigma_m, {0, 100}, "departure from the path per axis [m]");
  v.number("drift_time", drift_time_s, {0.02, 1000}, "its correlation time [s]");
  v.number("wind_speed", wind_speed_mps, {0, 100}, "turns a fixed camera into the wind [m/s]");
  v.number("wind_from", wind_from_deg, {-360, 360},
           "where the wind comes from, from north clockwise [deg]");
  v.flag("attitude_tags", attitude_tags, "photos carry the camera's attitude, as a gimbal tags it");
  v.number("attitude_sigma", attitude_sigma_deg, {0, 90}, "error of the tags per angle [deg]");
}

Intervals intervalsFromText(const std::string& text, const std::string& what) {
  Intervals intervals;
  std::istringstream list(text);
  for (std::string item; std::getline(list, item, ',');) {
    std::istringstream in(item);
    double begin = 0, end = 0;
    char colon = 0;
    std::string rest;
    if (!(in >> begin >> colon >> end) || colon != ':' || (in >> rest) || !(end >= begin))
      throw UsageError(
          fmt::format("{}'{}' is not T0:T1 in seconds, as in 20:35, 60:75", what, trimmed(item)));
    intervals.emplace_back(begin, end);
  }
  return intervals;
}

bool inAnyInterval(const Intervals& intervals, double t_s) {
  return std::any_of(intervals.begin(), intervals.end(),
                     [t_s](const auto& i) { return t_s >= i.first && t_s <= i.second; });
}

FlightOptions shareOf(const FlightOptions& whole, int k, int n, double shared_m) {
  const double slab = whole.width_m / n;
  const double low = k * slab - (k > 0 ? shared_m / 2 : 0);
  const double high = (k + 1) * slab + (k + 1 < n ? shared_m / 2 : 0);
  const double across = (low + high - whole.width_m) / 2;  // to the right of the heading
  const double heading = whole.heading_deg * M_PI / 180;
  FlightOptions share = whole;
  share.width_m = high - low;
  share.center_e_m += across * std::cos(heading);
  share.center_n_m -= across * std::sin(heading);
  return share;
}

class Flight::Impl {
 public:
  Impl(const FlightOptions& o, const Footprint& footprint, double ground_z_m, std::uint64_t seed,
       const std::string& what)
      : options_(o), z_(ground_z_m + o.height_m), path_(o, footprint) {
    for (int a = 0; a < 3; ++a) {
      wobble_.emplace_back(streamSeed(seed, fmt::format("wobble {}", a)), o.wobble_time_s);
      drift_.emplace_back(streamSeed(seed, fmt::format("drift {}", a)), o.drift_time_s);
    }
    const double spacing = o.photo_interval_s > 0 ? o.photo_interval_s * o.speed_mps
                                                  : (1 - o.forward_overlap) * footprint.along_m;
    const Intervals gaps = intervalsFromText(o.gaps, what + "gaps: ");
    for (const double s : photoPlaces(path_, spacing, o.photos_in_turns)) {
      const double t = std::round(s / o.speed_mps * kMicroseconds) / kMicroseconds;
      if (!inAnyInterval(gaps, t)) times_.push_back(t);
    }
    if (times_.size() < 2)
      throw UsageError(fmt::format(
          "{}{} photo{} on an area of {:.0f} x {:.0f} m, of which one photo covers {:.0f} x {:.0f} "
          "m: enlarge length and width, fly lower, or shorten the gaps",
          what, times_.size(), times_.size() == 1 ? "" : "s", o.length_m, o.width_m,
          footprint.along_m, footprint.across_m));
  }

  double duration_s() const { return path_.length() / options_.speed_mps; }
  const std::vector<double>& photoTimes() const { return times_; }
  const FlightPath& path() const { return path_; }

  Eigen::Isometry3d T_world_body(double t) const {
    const double v = options_.speed_mps, s = v * t;
    const Course course = path_.at(s);
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translation() = Eigen::Vector3d(course.position.x(), course.position.y(), z_) +
                      options_.drift_sigma_m * valueOf(drift_, t);
    T.linear() = turned(course.angle, Eigen::Vector3d::UnitZ());
    if (options_.mount != "fixed") return T;
    const double roll_way = v * kRollTime_s;
    const double curvature =
        (path_.at(s + roll_way).angle - path_.at(s - roll_way).angle) / (2 * roll_way);
    const double bank = std::atan(v * v * curvature / kGravity);  // coordinated turn
    T.linear() = turned(course.angle + crab(course.angle), Eigen::Vector3d::UnitZ()) *
                 turned(-bank, Eigen::Vector3d::UnitX()) * wobble(t);
    return T;
  }

  Eigen::Isometry3d T_world_cam(double t) const {
    Eigen::Matrix3d R_body_cam;  // straight down, top of the photo forward
    R_body_cam << 0, -1, 0, -1, 0, 0, 0, 0, -1;
    Eigen::Isometry3d T = T_world_body(t);
    if (options_.mount != "fixed") T.linear() *= wobble(t);
    T.linear() *= R_body_cam;
    return T;
  }

 private:
  static Eigen::Vector3d valueOf(const std::vector<SmoothNoise>& noise, double t) {
    return {noise[0].at(t), noise[1].at(t), noise[2].at(t)};
  }
  Eigen::Matrix3d wobble(double t) const {
    const Eigen::Vector3d v = options_.wobble_sigma_deg * M_PI / 180 * valueOf(wobble_, t);
    return turned(v.norm(), v.norm() > 0 ? v.normalized() : Eigen::Vector3d::UnitZ().eval());
  }
  /// Angle from the course to the nose that the wind asks for.
  double crab(double course) const {
    const double blows_to = (90 - options_.wind_from_deg) * M_PI / 180 + M_PI;
    const double left = options_.wind_speed_mps * std::sin(blows_to - course);
    const double forward = options_.wind_speed_mps * std::cos(blows_to - course);
    return std::atan2(-left, options_.speed_mps - forward);
  }

  FlightOptions options_;
  double z_;
  FlightPath path_;
  std::vector<SmoothNoise> wobble_, drift_;
  std::vector<double> times_;
};

Flight::Flight(const FlightOptions& options, const Footprint& footprint, double ground_z_m,
               std::uint64_t seed, const std::string& what)
    : impl_(std::make_unique<Impl>(options, footprint, ground_z_m, seed, what)) {}
Flight::~Flight() = default;
Flight::Flight(Flight&&) noexcept = default;

double Flight::duration_s() const { return impl_->duration_s(); }
const std::vector<double>& Flight::photoTimes() const { return impl_->photoTimes(); }
Eigen::Isometry3d Flight::T_world_cam(double t_s) const { return impl_->T_world_cam(t_s); }
Eigen::Isometry3d Flight::T_world_body(double t_s) const { return impl_->T_world_body(t_s); }
std::size_t Flight::strips() const { return impl_->path().strips().size(); }

CameraMotion Flight::motionAt(double t_s) const {
  constexpr double kStep = 1e-3;
  CameraMotion motion;
  motion.T_world_cam = T_world_cam(t_s);
  const Eigen::Isometry3d before = T_world_cam(t_s - kStep), after = T_world_cam(t_s + kStep);
  motion.velocity_mps = (after.translation() - before.translation()) / (2 * kStep);
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(before.linear().transpose() * after.linear()));
  motion.angular_velocity_radps = turn.angle() / (2 * kStep) * turn.axis();
  return motion;
}

}  // namespace cf
