// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "cf/base/options.h"
#include "cf/base/time.h"
#include "cf/geodesy/local_frame.h"
#include "cf/simulate/flight_plan.h"
#include "cf/simulate/gnss_receiver.h"
#include "cf/simulate/photographer.h"
#include "cf/simulate/scene.h"
#include "cf/simulate/true_camera.h"
#include "cf/types/camera_model.h"

namespace cf {

class Config;

/// [simulation]
struct SimulationOptions {
  int seed = 1;
  std::string origin = "46.95, 7.44, 540";  ///< "LAT, LON, H"
  std::string start = "1780308000";         ///< seconds UTC
  int uavs = 0;
  double shared_m = 20;
  double stagger_s = 0;
  double depth_megapixels = 0.5;
  double reference_spacing_m = 0.25;

  void visit(OptionVisitor& v);
};

/// [camera], and any key of it in [uav.NAME]: what takes the photos, and what the rawlog says.
struct LensOptions {
  int photo_width = 2000, photo_height = 1500;
  double fov_deg = 73.74;
  double focal_px = 0;
  double k1 = 0, k2 = 0, k3 = 0, p1 = 0, p2 = 0;
  double cx_offset_px = 0, cy_offset_px = 0;
  double told_focal_error = 0;
  double told_focal_sigma = 5;
  bool told_distortion = false;

  void visit(OptionVisitor& v);

  TrueCamera trueCamera() const;
  /// As told: focal length off by the error; the principal point in the centre and no distortion
  /// unless that is told.
  CameraModel toldCamera() const;
};

/// One UAV, its sections put together: the share of [flight], and [uav.NAME].
struct SimulatedUavOptions {
  std::string name;
  FlightOptions flight;
  LensOptions lens;
  GnssOptions gnss;
};

/// Everything that a simulation is told.
struct SimulationSetup {
  SimulationOptions simulation;
  SceneOptions scene;
  PhotoOptions photo;
  std::vector<SimulatedUavOptions> uavs;
  Geodetic origin;
  TimeNs start = 0;
};

/// Reads all sections. The UAVs are uav1 to uavN, which share the area of [flight], and those of
/// further sections [uav.NAME]. Throws UsageError on what is unknown, out of range or no UAV.
SimulationSetup loadSimulation(Config& config);

}  // namespace cf
