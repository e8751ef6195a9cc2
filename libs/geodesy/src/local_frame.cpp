// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/geodesy/local_frame.h"

#include <fmt/format.h>

#include <GeographicLib/Geocentric.hpp>
#include <cmath>
#include <vector>

#include "cf/base/error.h"
#include "cf/geodesy/utm.h"

namespace cf {

LocalFrame::LocalFrame(const Geodetic& origin) : origin_(origin) {
  if (!std::isfinite(origin.latitude_deg) || !std::isfinite(origin.longitude_deg) ||
      !std::isfinite(origin.height_m) || std::abs(origin.latitude_deg) > 90)
    throw RunError(
        fmt::format("{}, {}, {} cannot be the origin of a map: latitude, longitude in "
                    "degrees and height in metres are needed",
                    origin.latitude_deg, origin.longitude_deg, origin.height_m));
  Eigen::Vector3d p;
  std::vector<double> rotation(9);
  GeographicLib::Geocentric::WGS84().Forward(origin.latitude_deg, origin.longitude_deg,
                                             origin.height_m, p.x(), p.y(), p.z(), rotation);
  T_ecef_enu_.setIdentity();
  T_ecef_enu_.linear() =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rotation.data());
  T_ecef_enu_.translation() = p;
}

Eigen::Vector3d LocalFrame::toEnu(const Geodetic& p) const {
  Eigen::Vector3d ecef;
  GeographicLib::Geocentric::WGS84().Forward(p.latitude_deg, p.longitude_deg, p.height_m, ecef.x(),
                                             ecef.y(), ecef.z());
  return T_ecef_enu_.linear().transpose() * (ecef - T_ecef_enu_.translation());
}

Geodetic LocalFrame::toGeodetic(const Eigen::Vector3d& p_enu) const {
  const Eigen::Vector3d ecef = T_ecef_enu_ * p_enu;
  Geodetic p;
  GeographicLib::Geocentric::WGS84().Reverse(ecef.x(), ecef.y(), ecef.z(), p.latitude_deg,
                                             p.longitude_deg, p.height_m);
  return p;
}

std::string LocalFrame::utmZone() const {
  return utmZoneOf(origin_.latitude_deg, origin_.longitude_deg).text();
}

int LocalFrame::utmEpsg() const {
  return utmZoneOf(origin_.latitude_deg, origin_.longitude_deg).epsg();
}

}  // namespace cf
