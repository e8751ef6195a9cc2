// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/crs_wkt.h"

#include <cpl_conv.h>
#include <fmt/format.h>

#include "cf/base/error.h"
#include "gdal_support.h"

namespace cf {
namespace {

constexpr char kMeanSeaLevel[] =
    R"(VERT_CS["MSL height",VERT_DATUM["Mean Sea Level",2005,AUTHORITY["EPSG","5100"]],)"
    R"(UNIT["metre",1,AUTHORITY["EPSG","9001"]],AXIS["Gravity-related height",UP],)"
    R"(AUTHORITY["EPSG","5714"]])";
constexpr char kEllipsoid[] =
    R"(VERT_CS["WGS 84 ellipsoidal height",VERT_DATUM["World Geodetic System 1984",2002],)"
    R"(UNIT["metre",1,AUTHORITY["EPSG","9001"]],AXIS["Ellipsoidal height",UP]])";

}  // namespace

std::string crsWkt(int epsg, HeightDatum datum) {
  const QuietGdal quiet;
  const GdalReference reference(OSRNewSpatialReference(nullptr));
  char* text = nullptr;
  if (OSRImportFromEPSG(reference.get(), epsg) != OGRERR_NONE ||
      OSRIsProjected(reference.get()) == 0 || OSRExportToWkt(reference.get(), &text) != OGRERR_NONE)
    throw RunError(fmt::format("EPSG:{} is not known as a projected reference system", epsg));
  const std::string horizontal = text;
  CPLFree(text);
  if (datum == HeightDatum::kUnknown) return horizontal;
  const bool msl = datum == HeightDatum::kMsl;
  return fmt::format(R"(COMPD_CS["EPSG:{} with {}",{},{}])", epsg,
                     msl ? "heights above mean sea level" : "ellipsoidal heights", horizontal,
                     msl ? kMeanSeaLevel : kEllipsoid);
}

}  // namespace cf
