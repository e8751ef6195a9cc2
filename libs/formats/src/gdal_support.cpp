// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "gdal_support.h"

#include <cpl_conv.h>
#include <cpl_error.h>

#include "cf/base/error.h"

namespace cf {

QuietGdal::QuietGdal() {
  GDALAllRegister();
  CPLPushErrorHandler(CPLQuietErrorHandler);
  CPLErrorReset();
}

QuietGdal::~QuietGdal() { CPLPopErrorHandler(); }

void failGdal(const std::filesystem::path& path, const std::string& action) {
  std::string reason = CPLGetLastErrorMsg();
  for (char& c : reason)
    if (c == '\n' || c == '\r') c = ' ';
  throw RunError(path.string() + ": " + action + (reason.empty() ? "" : ": ") + reason);
}

std::string gdalWkt(const std::filesystem::path& path, const std::string& crs) {
  const GdalReference reference(OSRNewSpatialReference(nullptr));
  char* wkt = nullptr;
  if (OSRSetFromUserInput(reference.get(), crs.c_str()) != OGRERR_NONE ||
      OSRExportToWkt(reference.get(), &wkt) != OGRERR_NONE)
    failGdal(path, "cannot be written with the reference system '" + crs + "'");
  const std::string text = wkt;
  CPLFree(wkt);
  return text;
}

}  // namespace cf
