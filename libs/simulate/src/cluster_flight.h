// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "cf/simulate/simulation_options.h"
#include "cf/types/image_frame.h"

namespace cf {

struct PlannedPhoto {
  std::string name;
  TimeNs time = 0;
  CameraMotion motion;                     ///< at that time, exactly
  std::optional<GimbalAttitude> attitude;  ///< as tagged
  std::uint64_t seed = 0;                  ///< of its light and noise
};

/// One UAV's flight, decided to the last photo and fix.
struct PlannedUav {
  SimulatedUavOptions options;
  TrueCamera camera;
  CameraModel told;
  Footprint footprint;
  double ground_z_m = 0;
  std::size_t strips = 0;
  double duration_s = 0;
  std::vector<PlannedPhoto> photos;
  GnssRecord gnss;

  double gsd_m() const { return options.flight.height_m / camera.focal; }
};

/// The ground that the photos of all UAVs can show, margins included.
Eigen::AlignedBox2d areaOf(const SimulationSetup& setup);

/// All UAVs over this scene. Throws UsageError where one would hit something, or take no photos.
std::vector<PlannedUav> planCluster(const SimulationSetup& setup, const Scene& scene,
                                    const LocalFrame& world);

}  // namespace cf
