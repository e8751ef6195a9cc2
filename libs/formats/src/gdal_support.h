// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gdal.h>
#include <ogr_srs_api.h>

#include <filesystem>
#include <memory>
#include <string>

namespace cf {

struct CloseGdalDataset {
  void operator()(GDALDatasetH dataset) const { GDALClose(dataset); }
};
using GdalDataset = std::unique_ptr<void, CloseGdalDataset>;

struct DestroyGdalReference {
  void operator()(OGRSpatialReferenceH reference) const { OSRDestroySpatialReference(reference); }
};
using GdalReference = std::unique_ptr<void, DestroyGdalReference>;

/// While it lives GDAL's messages stay off stderr; failGdal() tells the last one.
class QuietGdal {
 public:
  QuietGdal();
  ~QuietGdal();
  QuietGdal(const QuietGdal&) = delete;
  QuietGdal& operator=(const QuietGdal&) = delete;
};

/// Throws RunError: the path, what could not be done, GDAL's reason.
[[noreturn]] void failGdal(const std::filesystem::path& path, const std::string& action);

/// WKT of a reference system given as WKT or "EPSG:…"; RunError names the file that it is for.
std::string gdalWkt(const std::filesystem::path& path, const std::string& crs);

}  // namespace cf
