// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "cf/base/result.h"
#include "cf/geodesy/local_frame.h"

namespace cf {

/// Zone of the Universal Transverse Mercator grid on WGS84.
struct UtmZone {
  int zone = 0;  ///< 1..60
  bool north = true;

  std::string text() const;  ///< "15N"
  int epsg() const { return (north ? 32600 : 32700) + zone; }
};

/// The standard zone of a position, Norway's and Svalbard's exceptions included.
UtmZone utmZoneOf(double latitude_deg, double longitude_deg);

/// "17N", "56s". Letters other than N and S (latitude bands) fail.
Result<UtmZone> utmZoneFromText(const std::string& text);
/// 32601..32660 and 32701..32760; anything else fails.
Result<UtmZone> utmZoneFromEpsg(int epsg);

/// Easting and northing [m] to geodetic; fails where they are outside what UTM covers.
Result<Geodetic> utmToGeodetic(const UtmZone& zone, double easting_m, double northing_m,
                               double height_m);

struct UtmPosition {
  double easting_m = 0;
  double northing_m = 0;
};
/// Geodetic to the given zone, which may be a neighbour of the standard one.
Result<UtmPosition> geodeticToUtm(const UtmZone& zone, const Geodetic& p);

}  // namespace cf
