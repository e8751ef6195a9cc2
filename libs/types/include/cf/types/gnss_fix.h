// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>

#include "cf/base/time.h"

namespace cf {

/// What a height counts from.
enum class HeightDatum { kUnknown, kEllipsoid, kMsl };

inline const char* name(HeightDatum datum) {
  return datum == HeightDatum::kEllipsoid ? "ellipsoid"
         : datum == HeightDatum::kMsl     ? "msl"
                                          : "unknown";
}

/// One GNSS fix, WGS84.
struct GnssFix {
  TimeNs time = 0;
  double latitude_deg = 0;
  double longitude_deg = 0;
  double height_m = 0;
  Eigen::Vector3d sigma_enu_m = {2.0, 2.0, 4.0};  ///< standard deviation: east, north, up
  HeightDatum datum = HeightDatum::kUnknown;
};

/// A fix in the world frame (ENU at the world's origin), interpolated to a photo's time.
struct GnssPosition {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Ones();
};

}  // namespace cf
