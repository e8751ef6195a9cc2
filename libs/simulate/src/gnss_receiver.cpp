// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/simulate/gnss_receiver.h"

#include <algorithm>
#include <cmath>

#include "random_stream.h"

namespace cf {
namespace {

constexpr double kMicroseconds = 1e6;

std::vector<double> fixTimes(const GnssOptions& o, const Flight& flight) {
  if (o.rate_hz == 0) return flight.photoTimes();
  std::vector<double> times;
  const double last = flight.photoTimes().back();
  for (int i = 0; i / o.rate_hz <= last + 1 / o.rate_hz; ++i)
    times.push_back(std::round(i / o.rate_hz * kMicroseconds) / kMicroseconds);
  return times;
}

Eigen::Vector3d normal3(RandomStream& random) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return {x, y, z};
}

HeightDatum datumFrom(const std::string& text) {
  return text == "ellipsoid" ? HeightDatum::kEllipsoid
         : text == "msl"     ? HeightDatum::kMsl
                             : HeightDatum::kUnknown;
}

Eigen::Vector3d biasOf(const GnssOptions& o, std::uint64_t seed) {
  RandomStream random(streamSeed(seed, "bias"));
  const double e = random.uniform(-1, 1), n = random.uniform(-1, 1), u = random.uniform(-1, 1);
  return {o.bias_e_m + o.bias_limit_h_m * e, o.bias_n_m + o.bias_limit_h_m * n,
          o.bias_u_m + o.bias_limit_v_m * u};
}

}  // namespace

void GnssOptions::visit(OptionVisitor& v) {
  v.number("sigma_h", sigma_h_m, {0, 1000}, "white noise, east and north each [m]");
  v.number("sigma_v", sigma_v_m, {0, 1000}, "white noise of the height [m]");
  v.number("walk_h", walk_h, {0, 100}, "random walk, east and north each [m/sqrt(s)]");
  v.number("walk_v", walk_v, {0, 100}, "random walk of the height [m/sqrt(s)]");
  v.number("bias_e", bias_e_m, {-1e4, 1e4}, "constant error, east [m]");
  v.number("bias_n", bias_n_m, {-1e4, 1e4}, "constant error, north [m]");
  v.number("bias_u", bias_u_m, {-1e4, 1e4}, "constant error, up [m]");
  v.number("bias_limit_h", bias_limit_h_m, {0, 1e4},
           "further bias drawn for each UAV within this, east and north each [m]");
  v.number("bias_limit_v", bias_limit_v_m, {0, 1e4}, "the same for the height [m]");
  v.number("outlier_share", outlier_share, {0, 1}, "of the fixes");
  v.number("outlier_size", outlier_size_m, {0, 1e5},
           "length of an outlier's error, in any direction; half to one and a half of it [m]");
  v.text("outages", outages, "T0:T1, T2:T3: no fixes at these times after the UAV's start [s]");
  v.choice("datum", datum, {"ellipsoid", "msl", "unknown"}, "what the heights say they count from");
  v.number("datum_offset", datum_offset_m, {-1000, 1000},
           "recorded height minus height above the ellipsoid [m]");
  v.number("time_offset", time_offset_s, {-60, 60}, "recorded minus true time of a fix [s]");
  v.number("lever_forward", lever_forward_m, {-10, 10}, "antenna from the camera, UAV's axes [m]");
  v.number("lever_left", lever_left_m, {-10, 10}, "antenna from the camera, UAV's axes [m]");
  v.number("lever_up", lever_up_m, {-10, 10}, "antenna from the camera, UAV's axes [m]");
  v.number("rate", rate_hz, {0, 100}, "fixes per second [Hz]; 0 = one at each photo");
  v.number("told_sigma_h", told_sigma_h_m, {0, 1000},
           "sigma that the rawlog tells, east and north [m]; 0 = the true one");
  v.number("told_sigma_v", told_sigma_v_m, {0, 1000}, "the same for the height [m]");
}

GnssRecord simulateGnss(const GnssOptions& o, const Flight& flight, TimeNs start,
                        const LocalFrame& world, std::uint64_t seed, const std::string& what) {
  constexpr double kFinest_m = 0.001;  // no receiver tells a sigma of 0
  GnssRecord record;
  record.sigma_m = {o.sigma_h_m, o.sigma_h_m, o.sigma_v_m};
  record.bias_m = biasOf(o, seed);
  record.outages_s = intervalsFromText(o.outages, what + "outages: ");
  const double told_h = std::max(kFinest_m, o.told_sigma_h_m > 0 ? o.told_sigma_h_m : o.sigma_h_m);
  const double told_v = std::max(kFinest_m, o.told_sigma_v_m > 0 ? o.told_sigma_v_m : o.sigma_v_m);
  const Eigen::Vector3d lever(o.lever_forward_m, o.lever_left_m, o.lever_up_m);
  const Eigen::Vector3d walk_step(o.walk_h, o.walk_h, o.walk_v);

  RandomStream noise(streamSeed(seed, "noise")), walk(streamSeed(seed, "walk")),
      outliers(streamSeed(seed, "outliers"));
  Eigen::Vector3d walked = Eigen::Vector3d::Zero();
  double before = 0;
  for (const double t : fixTimes(o, flight)) {
    walked += std::sqrt(std::max(0.0, t - before)) * walk_step.cwiseProduct(normal3(walk));
    before = t;
    const Eigen::Vector3d white = record.sigma_m.cwiseProduct(normal3(noise));
    const bool outlier = outliers.uniform(0, 1) < o.outlier_share;
    const Eigen::Vector3d away = normal3(outliers).normalized();
    const double size = o.outlier_size_m * outliers.uniform(0.5, 1.5);

    if (inAnyInterval(record.outages_s, t)) continue;
    SimulatedFix fix;
    fix.true_m = flight.T_world_body(t) * lever;
    fix.measured_m = fix.true_m + record.bias_m + white + walked;
    if (outlier) fix.measured_m += size * away;
    fix.outlier = outlier;
    const Geodetic place = world.toGeodetic(fix.measured_m);
    fix.fix.time = start + std::llround((t + o.time_offset_s) * kMicroseconds) * 1000;
    fix.fix.latitude_deg = place.latitude_deg;
    fix.fix.longitude_deg = place.longitude_deg;
    fix.fix.height_m = place.height_m + o.datum_offset_m;
    fix.fix.sigma_enu_m = {told_h, told_h, told_v};
    fix.fix.datum = datumFrom(o.datum);
    fix.measured_m.z() += o.datum_offset_m;
    record.fixes.push_back(fix);
  }
  return record;
}

}  // namespace cf
