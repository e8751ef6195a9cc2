// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/geodesy/utm.h"

#include <fmt/format.h>

#include <GeographicLib/UTMUPS.hpp>
#include <cctype>

namespace cf {

std::string UtmZone::text() const { return fmt::format("{}{}", zone, north ? 'N' : 'S'); }

UtmZone utmZoneOf(double latitude_deg, double longitude_deg) {
  // UTM also beyond 84N and 80S, where the standard grid would be polar stereographic.
  const int zone =
      GeographicLib::UTMUPS::StandardZone(latitude_deg, longitude_deg, GeographicLib::UTMUPS::UTM);
  return {zone, latitude_deg >= 0};
}

Result<UtmZone> utmZoneFromText(const std::string& text) {
  const Failure bad{"bad_utm_zone", "'" + text + "' is not a UTM zone such as 17N"};
  std::size_t i = 0;
  int zone = 0;
  for (; i < text.size() && i < 2 && std::isdigit(static_cast<unsigned char>(text[i])); ++i)
    zone = zone * 10 + (text[i] - '0');
  if (i == 0 || i + 1 != text.size() || zone < 1 || zone > 60) return bad;
  const int letter = std::toupper(static_cast<unsigned char>(text[i]));
  if (letter != 'N' && letter != 'S') return bad;
  return UtmZone{zone, letter == 'N'};
}

Result<UtmZone> utmZoneFromEpsg(int epsg) {
  if (epsg >= 32601 && epsg <= 32660) return UtmZone{epsg - 32600, true};
  if (epsg >= 32701 && epsg <= 32760) return UtmZone{epsg - 32700, false};
  return Failure{"bad_utm_zone", fmt::format("EPSG:{} is not a UTM zone on WGS84", epsg)};
}

Result<Geodetic> utmToGeodetic(const UtmZone& zone, double easting_m, double northing_m,
                               double height_m) {
  Geodetic p;
  p.height_m = height_m;
  try {
    GeographicLib::UTMUPS::Reverse(zone.zone, zone.north, easting_m, northing_m, p.latitude_deg,
                                   p.longitude_deg);
  } catch (const GeographicLib::GeographicErr& e) {
    return Failure{"outside_utm", e.what()};
  }
  return p;
}

Result<UtmPosition> geodeticToUtm(const UtmZone& zone, const Geodetic& p) {
  UtmPosition utm;
  try {
    int zone_out = 0;
    bool north_out = true;
    double convergence_deg = 0, scale = 0;
    GeographicLib::UTMUPS::Forward(p.latitude_deg, p.longitude_deg, zone_out, north_out,
                                   utm.easting_m, utm.northing_m, convergence_deg, scale,
                                   zone.zone);
    constexpr double kFalseNorthing_m = 10'000'000;  // of the southern hemisphere
    if (north_out && !zone.north) utm.northing_m += kFalseNorthing_m;
    if (!north_out && zone.north) utm.northing_m -= kFalseNorthing_m;
  } catch (const GeographicLib::GeographicErr& e) {
    return Failure{"outside_utm", e.what()};
  }
  return utm;
}

}  // namespace cf
