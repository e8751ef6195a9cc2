// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "cf/base/time.h"
#include "cf/import/focal.h"
#include "cf/types/gnss_fix.h"
#include "cf/types/image_frame.h"

namespace cf {

/// When a photo says it was taken. Times are those of the tag, before any correction (timing.h).
struct PhotoTime {
  std::optional<TimeNs> gps;     ///< GPSDateStamp and GPSTimeStamp: UTC
  std::optional<TimeNs> camera;  ///< DateTimeOriginal with its sub-seconds; UTC if the offset is
                                 ///< tagged, else the camera's local time read as if it were UTC
  bool sub_seconds = false;      ///< the camera time is finer than a second
};

/// Where a photo says it was taken. The sigma is that of its tags (RTK), if any.
struct PhotoPosition {
  double latitude_deg = 0;
  double longitude_deg = 0;
  std::optional<double> height_m;
  HeightDatum datum = HeightDatum::kUnknown;
  std::optional<Eigen::Vector3d> sigma_enu_m;
};

/// The tags of one photo that matter.
struct PhotoTags {
  bool readable = false;  ///< false: the file is no image, or its header is destroyed
  int width = 0;          ///< [px]
  int height = 0;         ///< [px]
  int orientation = 1;    ///< EXIF; photos are processed as the sensor saw them, whatever this says
  PhotoTime time;
  std::optional<PhotoPosition> position;
  std::optional<GimbalAttitude> attitude;
  std::optional<double> height_above_ground_m;
  FocalTags focal;
};

/// EXIF items by GDAL's names ("EXIF_GPSLatitude") with GDAL's way of writing values.
using ExifItems = std::map<std::string, std::string>;

/// Reads a photo's header through GDAL (JPEG, TIFF, PNG); never its pixels. A file that cannot be
/// read gives tags with `readable` false.
PhotoTags readPhotoTags(const std::filesystem::path& file);

/// The same from the items and the XMP packet (may be empty) alone.
PhotoTags tagsFrom(const ExifItems& exif, const std::string& xmp);

/// Value of an XMP property whatever its namespace prefix, as attribute or element; empty if none.
std::string xmpValue(const std::string& xmp, const std::string& property);

}  // namespace cf
