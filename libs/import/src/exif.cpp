// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/import/exif.h"

#include <cpl_error.h>
#include <cpl_string.h>
#include <gdal.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "cf/base/text.h"
#include "gps_tags.h"

namespace cf {
namespace {

struct CloseDataset {
  void operator()(GDALDatasetH dataset) const { GDALClose(dataset); }
};
using Dataset = std::unique_ptr<void, CloseDataset>;

Dataset open(const std::filesystem::path& file) {
  GDALAllRegister();
  const char* const drivers[] = {"JPEG", "GTiff", "PNG", nullptr};
  const char* const siblings[] = {nullptr};  // do not look for sidecar files
  CPLPushErrorHandler(CPLQuietErrorHandler);
  Dataset dataset(
      GDALOpenEx(file.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, drivers, nullptr, siblings));
  CPLPopErrorHandler();
  return dataset;
}

ExifItems itemsOf(const Dataset& dataset) {
  ExifItems items;
  CPLPushErrorHandler(CPLQuietErrorHandler);
  for (const char* domain : {"", "EXIF"}) {
    char** list = GDALGetMetadata(dataset.get(), domain);
    for (int i = 0; i < CSLCount(list); ++i) {
      const std::string entry = list[i];
      const std::size_t equals = entry.find('=');
      if (equals != std::string::npos)
        items.emplace(entry.substr(0, equals), entry.substr(equals + 1));
    }
  }
  CPLPopErrorHandler();
  return items;
}

std::string xmpOf(const Dataset& dataset) {
  CPLPushErrorHandler(CPLQuietErrorHandler);
  char** list = GDALGetMetadata(dataset.get(), "xml:XMP");
  CPLPopErrorHandler();
  return CSLCount(list) > 0 ? std::string(list[0]) : std::string();
}

FocalTags focalFrom(const ExifItems& exif) {
  FocalTags tags;
  tags.focal_mm = firstNumber(exif, "EXIF_FocalLength");
  tags.focal_35mm = firstNumber(exif, "EXIF_FocalLengthIn35mmFilm");
  constexpr double kMmPerInch = 25.4, kMmPerCm = 10;
  const double unit_mm =
      firstNumber(exif, "EXIF_FocalPlaneResolutionUnit") == 3 ? kMmPerCm : kMmPerInch;
  tags.focal_plane_px_per_mm = firstNumber(exif, "EXIF_FocalPlaneXResolution") / unit_mm;
  constexpr double kWidest = 1e6;
  tags.original_width =
      static_cast<int>(std::clamp(std::max(firstNumber(exif, "EXIF_Related_Image_Width"),
                                           firstNumber(exif, "EXIF_PixelXDimension")),
                                  0., kWidest));
  return tags;
}

std::optional<GimbalAttitude> attitudeFrom(const std::string& xmp) {
  const auto yaw = numberFrom(xmpValue(xmp, "GimbalYawDegree"));
  const auto pitch = numberFrom(xmpValue(xmp, "GimbalPitchDegree"));
  const auto roll = numberFrom(xmpValue(xmp, "GimbalRollDegree"));
  if (!yaw || !pitch || !roll) return std::nullopt;
  return GimbalAttitude{*yaw, *pitch, *roll};
}

}  // namespace

std::string xmpValue(const std::string& xmp, const std::string& property) {
  const std::string name = ":" + property;
  for (std::size_t at = xmp.find(name); at != std::string::npos; at = xmp.find(name, at + 1)) {
    std::size_t i = at + name.size();
    if (i < xmp.size() && xmp[i] == '>') {  // <ns:Property>value</ns:Property>
      const std::size_t end = xmp.find('<', i);
      if (end == std::string::npos) return {};
      return trimmed(xmp.substr(i + 1, end - i - 1));
    }
    i = xmp.find_first_not_of(" \t\r\n", i);
    if (i == std::string::npos || xmp[i] != '=') continue;  // a longer name
    i = xmp.find_first_not_of(" \t\r\n", i + 1);
    if (i == std::string::npos || (xmp[i] != '"' && xmp[i] != '\'')) continue;
    const std::size_t end = xmp.find(xmp[i], i + 1);
    if (end == std::string::npos) return {};
    return trimmed(xmp.substr(i + 1, end - i - 1));
  }
  return {};
}

PhotoTags tagsFrom(const ExifItems& exif, const std::string& xmp) {
  PhotoTags tags;
  tags.readable = true;
  const double orientation = firstNumber(exif, "EXIF_Orientation");
  if (orientation >= 1 && orientation <= 8) tags.orientation = static_cast<int>(orientation);
  tags.time = timeFrom(exif);
  tags.position = positionFrom(exif, xmp);
  tags.attitude = attitudeFrom(xmp);
  tags.height_above_ground_m = numberFrom(xmpValue(xmp, "RelativeAltitude"));
  tags.focal = focalFrom(exif);
  return tags;
}

PhotoTags readPhotoTags(const std::filesystem::path& file) {
  const Dataset dataset = open(file);
  if (!dataset) return {};
  PhotoTags tags = tagsFrom(itemsOf(dataset), xmpOf(dataset));
  tags.width = GDALGetRasterXSize(dataset.get());
  tags.height = GDALGetRasterYSize(dataset.get());
  return tags;
}

}  // namespace cf
