// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/simulate/simulation_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "cf/base/error.h"
#include "cf/config/config.h"

namespace cf {
namespace {

constexpr const char* kUavSection = "uav.";

Geodetic originFrom(const std::string& text, const std::string& where) {
  Geodetic origin;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%lf , %lf , %lf %c", &origin.latitude_deg, &origin.longitude_deg,
                  &origin.height_m, &rest) != 3 ||
      !(std::abs(origin.latitude_deg) <= 89) || !(std::abs(origin.longitude_deg) <= 180) ||
      !(std::abs(origin.height_m) < 1e5))
    throw UsageError(fmt::format(
        "{}[simulation] origin = {}: give latitude, longitude [deg] and height [m], as in {}",
        where, text, SimulationOptions().origin));
  return origin;
}

TimeNs startFrom(const std::string& text, const std::string& where) {
  try {
    return timeFromText(text) / 1000 * 1000;
  } catch (const RunError&) {
    throw UsageError(fmt::format("{}[simulation] start = {}: give seconds UTC, as in {}", where,
                                 text, SimulationOptions().start));
  }
}

/// The UAVs that share the area, then those that only a section names.
std::vector<SimulatedUavOptions> uavsOf(const SimulationOptions& simulation,
                                        const SimulatedUavOptions& whole,
                                        const std::vector<std::string>& sections) {
  std::vector<SimulatedUavOptions> uavs;
  for (int k = 0; k < simulation.uavs; ++k) {
    SimulatedUavOptions uav = whole;
    uav.name = fmt::format("uav{}", k + 1);
    uav.flight = shareOf(whole.flight, k, simulation.uavs, simulation.shared_m);
    uav.flight.start_delay_s += k * simulation.stagger_s;
    uavs.push_back(uav);
  }
  for (const std::string& section : sections) {
    const std::string name = section.substr(std::string(kUavSection).size());
    if (std::any_of(uavs.begin(), uavs.end(), [&](const auto& u) { return u.name == name; }))
      continue;
    uavs.push_back(whole);
    uavs.back().name = name;
  }
  return uavs;
}

}  // namespace

void SimulationOptions::visit(OptionVisitor& v) {
  v.integer("seed", seed, {0, 2147483647}, "of everything random");
  v.text("origin", origin, "LAT, LON, H of the world's ENU frame; H above the ellipsoid [m]");
  v.text("start", start, "when the UAVs start [s UTC]");
  v.integer("uavs", uavs, {0, 1000},
            "UAVs uav1, uav2, … that share the area of [flight] side by side; 0: only those of "
            "[uav.NAME]");
  v.number("shared", shared_m, {0, 1e4}, "width that neighbours both cover [m]");
  v.number("stagger", stagger_s, {0, 1e5}, "from the start of one to that of the next [s]");
  v.number("depth_megapixels", depth_megapixels, {0, 20},
           "size of the true depth maps [MP]; 0 = none");
  v.number("reference_spacing", reference_spacing_m, {0, 100},
           "grid of the reference cloud and the surface model [m]; 0 = none");
}

void LensOptions::visit(OptionVisitor& v) {
  v.integer("photo_width", photo_width, {64, 8192}, "[px]");
  v.integer("photo_height", photo_height, {64, 8192}, "[px]");
  v.number("fov", fov_deg, {5, 140}, "horizontal field of view without distortion [deg]");
  v.number("focal", focal_px, {0, 1e5}, "focal length [px]; 0 = from fov");
  v.number("k1", k1, {-1, 1}, "radial distortion (OpenCV's order and sign)");
  v.number("k2", k2, {-1, 1}, "radial distortion");
  v.number("k3", k3, {-1, 1}, "radial distortion");
  v.number("p1", p1, {-0.1, 0.1}, "tangential distortion");
  v.number("p2", p2, {-0.1, 0.1}, "tangential distortion");
  v.number("cx_offset", cx_offset_px, {-1000, 1000}, "principal point from the centre [px]");
  v.number("cy_offset", cy_offset_px, {-1000, 1000}, "principal point from the centre [px]");
  v.number("told_focal_error", told_focal_error, {-50, 50},
           "of the focal length that the rawlog tells [percent]");
  v.number("told_focal_sigma", told_focal_sigma, {0, 50},
           "standard deviation that it tells [percent]; 0 = held fixed");
  v.flag("told_distortion", told_distortion,
         "the rawlog tells distortion and principal point; otherwise zero and the centre");
}

TrueCamera LensOptions::trueCamera() const {
  TrueCamera c;
  c.width = photo_width;
  c.height = photo_height;
  c.focal = focal_px > 0 ? focal_px : photo_width / 2.0 / std::tan(fov_deg / 2 * M_PI / 180);
  c.cx = (photo_width - 1) / 2.0 + cx_offset_px;
  c.cy = (photo_height - 1) / 2.0 + cy_offset_px;
  c.k1 = k1;
  c.k2 = k2;
  c.k3 = k3;
  c.p1 = p1;
  c.p2 = p2;
  return c;
}

CameraModel LensOptions::toldCamera() const {
  constexpr double kDistortionSigma = 0.1;  // as cf-import gives it
  const TrueCamera truth = trueCamera();
  CameraModel told;
  told.width = truth.width;
  told.height = truth.height;
  told.fx = told.fy = truth.focal * (1 + told_focal_error / 100);
  told.cx = (truth.width - 1) / 2.0;
  told.cy = (truth.height - 1) / 2.0;
  told.focal_sigma = told.fx * told_focal_sigma / 100;
  told.k1_sigma = told.k2_sigma = kDistortionSigma;
  if (!told_distortion) return told;
  told.cx = truth.cx;
  told.cy = truth.cy;
  told.k1 = truth.k1;
  told.k2 = truth.k2;
  told.k3 = truth.k3;
  told.p1 = truth.p1;
  told.p2 = truth.p2;
  return told;
}

SimulationSetup loadSimulation(Config& config) {
  SimulationSetup setup;
  SimulatedUavOptions whole;
  config.load("simulation", setup.simulation);
  config.load("scene", setup.scene);
  config.load("photo", setup.photo);
  config.load("camera", whole.lens);
  config.load("flight", whole.flight);
  config.load("gnss", whole.gnss);
  setup.uavs = uavsOf(setup.simulation, whole, config.sections(kUavSection));
  for (SimulatedUavOptions& uav : setup.uavs) {
    const std::string section = kUavSection + uav.name;
    if (uav.name.empty() || uav.name.find('/') != std::string::npos)
      throw UsageError(
          fmt::format("{}: [{}] the name becomes a file name: it may not be empty nor hold '/'",
                      config.file().string(), section));
    config.load(section, uav.flight);
    config.load(section, uav.lens);
    config.load(section, uav.gnss);
  }
  config.rejectUnknown();
  const std::string where = config.file().string() + ": ";
  if (setup.uavs.empty())
    throw UsageError(where + "no UAV: give [simulation] uavs = N or sections [uav.NAME]");
  setup.origin = originFrom(setup.simulation.origin, where);
  setup.start = startFrom(setup.simulation.start, where);
  return setup;
}

}  // namespace cf
