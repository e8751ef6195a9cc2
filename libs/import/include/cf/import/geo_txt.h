// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cf/geodesy/local_frame.h"
#include "cf/types/gnss_fix.h"
#include "cf/types/image_frame.h"

namespace cf {

/// One line of a geo.txt.
struct GeoEntry {
  std::string name;  ///< base name of a photo, or the end of its path: "100MEDIA/DJI_0001.JPG"
  Geodetic position;
  std::optional<GimbalAttitude> attitude;
  std::optional<Eigen::Vector2d> sigma_m;  ///< horizontal, vertical
};

struct GeoFile {
  HeightDatum datum = HeightDatum::kUnknown;
  std::vector<GeoEntry> entries;
};

/// Reads a geo.txt. First line the CRS, as crsFromText() of libs/geodesy knows it. Then lines
/// "name x y z [yaw pitch roll] [sigma_h sigma_v]", x being longitude or easting, y latitude or
/// northing; attitude as in GimbalAttitude. Empty lines and lines from # on are skipped.
/// Throws UsageError naming file and line.
GeoFile readGeoTxt(const std::filesystem::path& file);

}  // namespace cf
