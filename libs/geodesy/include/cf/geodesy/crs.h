// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "cf/base/result.h"
#include "cf/geodesy/local_frame.h"
#include "cf/geodesy/utm.h"
#include "cf/types/gnss_fix.h"

namespace cf {

/// Coordinate reference system of positions in text files: WGS84, geographic or UTM.
struct Crs {
  std::optional<UtmZone> utm;  ///< none: x is longitude, y latitude [deg]
  HeightDatum datum = HeightDatum::kUnknown;
};

/// "EPSG:4326" (heights of unknown datum), "EPSG:4979" (ellipsoidal), the code of a UTM zone
/// "EPSG:32617", "WGS84 UTM 17N", or a PROJ string of one of these on WGS84 in metres:
/// "+proj=utm +zone=17 [+south] …", "+proj=longlat …". Case does not matter. Anything else fails
/// with a sentence that says what is known.
Result<Crs> crsFromText(const std::string& text);

/// Position given as x y z in that system; x is longitude or easting. Fails where it is no place.
Result<Geodetic> geodeticFrom(const Crs& crs, const Eigen::Vector3d& p);

}  // namespace cf
