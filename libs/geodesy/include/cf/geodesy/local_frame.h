// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <string>

namespace cf {

/// A position on or above the WGS84 ellipsoid. Which surface the height counts from is up to the
/// caller; all conversions here take it as ellipsoidal.
struct Geodetic {
  double latitude_deg = 0;   ///< -90..90
  double longitude_deg = 0;  ///< -180..180
  double height_m = 0;
};

/// ENU frame (x east, y north, z up, metres) tangent to WGS84 at an origin.
/// Exact (GeographicLib's LocalCartesian conventions), not a small-angle approximation.
class LocalFrame {
 public:
  /// Throws RunError if the origin is not finite or its latitude is beyond +-90 degrees.
  explicit LocalFrame(const Geodetic& origin);
  LocalFrame(double latitude_deg, double longitude_deg, double height_m)
      : LocalFrame(Geodetic{latitude_deg, longitude_deg, height_m}) {}

  const Geodetic& origin() const { return origin_; }

  Eigen::Vector3d toEnu(const Geodetic& p) const;
  Eigen::Vector3d toEnu(double latitude_deg, double longitude_deg, double height_m) const {
    return toEnu(Geodetic{latitude_deg, longitude_deg, height_m});
  }
  Geodetic toGeodetic(const Eigen::Vector3d& p_enu) const;
  Eigen::Vector3d toEcef(const Eigen::Vector3d& p_enu) const { return T_ecef_enu_ * p_enu; }

  /// Earth-centred, earth-fixed from this frame.
  const Eigen::Isometry3d& T_ecef_enu() const { return T_ecef_enu_; }
  /// This frame from another: p_this = T * p_other.
  Eigen::Isometry3d T_this_other(const LocalFrame& other) const {
    return T_ecef_enu_.inverse() * other.T_ecef_enu_;
  }

  /// UTM zone and hemisphere of the origin: "15N", "56S".
  std::string utmZone() const;
  /// EPSG code of that zone on WGS84: 32615, 32756.
  int utmEpsg() const;

 private:
  Geodetic origin_;
  Eigen::Isometry3d T_ecef_enu_;
};

}  // namespace cf
