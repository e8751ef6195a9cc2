// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "cf/import/exif.h"
#include "cf/import/geo_txt.h"
#include "cf/import/import.h"

namespace cf {

/// One photo on its way into a rawlog.
struct ImportedPhoto {
  std::filesystem::path source;
  bool readable = false;
  ImageFrame frame;  ///< frame.name is the photo's unique name; frame.file is not set yet
  std::string focal_source;
  std::optional<GnssFix> fix;
};

/// The photos of one folder in time order.
struct Flight {
  std::string name;
  std::filesystem::path folder;
  std::string time_source;
  std::vector<ImportedPhoto> photos;
};

/// Photos, in natural order of their paths, and what they say of themselves.
struct TaggedPhotos {
  std::vector<std::filesystem::path> files;
  std::vector<PhotoTags> tags;
};

/// The flight that a folder's photos make: names, times, cameras, positions. `camera` overrides the
/// tags where a photo has its shape. Adds to `warnings`.
Flight flightOf(const std::string& name, const std::filesystem::path& folder, TaggedPhotos photos,
                const ImportOptions& options, const std::optional<CameraModel>& camera,
                std::vector<std::string>& warnings);

/// The same of all photos in the folder.
Flight readFlight(const std::string& name, const std::filesystem::path& folder,
                  const ImportOptions& options, const std::optional<CameraModel>& camera,
                  std::size_t& ignored_files, std::vector<std::string>& warnings);

/// Positions, attitudes and sigmas of a geo.txt replace those of the photos that it names. Throws
/// UsageError if it names none of the photos, or one name fits several.
void applyGeo(const GeoFile& geo, const ImportOptions& options, std::vector<Flight>& flights,
              std::vector<std::string>& warnings);

/// Cuts one flight into UAVs as options.split says. Throws UsageError where that cannot be done.
std::vector<Flight> splitFlight(const Flight& flight, const std::string& split);

/// Sigma of a fix whose photo tags none: options.sigma_m, or the default of rawlogs.
Eigen::Vector3d defaultSigma(const ImportOptions& options);

}  // namespace cf
