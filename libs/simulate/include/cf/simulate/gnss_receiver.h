// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "cf/base/options.h"
#include "cf/geodesy/local_frame.h"
#include "cf/simulate/flight_plan.h"
#include "cf/types/gnss_fix.h"

namespace cf {

/// [gnss], and any key of it in [uav.NAME]: how a receiver errs.
struct GnssOptions {
  double sigma_h_m = 1.5, sigma_v_m = 3;
  double walk_h = 0, walk_v = 0;  ///< [m/sqrt(s)]
  double bias_e_m = 0, bias_n_m = 0, bias_u_m = 0;
  double bias_limit_h_m = 0, bias_limit_v_m = 0;
  double outlier_share = 0, outlier_size_m = 30;
  std::string outages;
  std::string datum = "ellipsoid";
  double datum_offset_m = 0;
  double time_offset_s = 0;
  double lever_forward_m = 0, lever_left_m = 0, lever_up_m = 0;
  double rate_hz = 0;
  double told_sigma_h_m = 0, told_sigma_v_m = 0;

  void visit(OptionVisitor& v);
};

struct SimulatedFix {
  GnssFix fix;                 ///< as recorded
  Eigen::Vector3d measured_m;  ///< the same in the world's ENU
  Eigen::Vector3d true_m;      ///< of the antenna when it was measured
  bool outlier = false;
};

/// What a receiver did, and its errors.
struct GnssRecord {
  std::vector<SimulatedFix> fixes;
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();  ///< white noise
  Eigen::Vector3d bias_m = Eigen::Vector3d::Zero();   ///< given and drawn; without the datum
  std::vector<std::pair<double, double>> outages_s;   ///< since the UAV's start
};

/// Fixes of one flight that started at `start`, at its photos or at the receiver's rate. Every kind
/// of error has its own random numbers, one for each fix, an outage's included: switching one off
/// leaves the others as they are. Throws UsageError that begins with `what`.
GnssRecord simulateGnss(const GnssOptions& options, const Flight& flight, TimeNs start,
                        const LocalFrame& world, std::uint64_t seed, const std::string& what);

}  // namespace cf
