// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/float_raster.h"

#include <cpl_string.h>
#include <cpl_vsi.h>
#include <fmt/format.h>
#include <gdal.h>

#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <opencv2/core.hpp>

#include "cf/base/error.h"
#include "cf/formats/atomic_file.h"
#include "gdal_support.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

/// A file in memory, removed at the end.
struct MemoryFile {
  MemoryFile() {
    static std::atomic<unsigned> count{0};
    name = fmt::format("/vsimem/cf_float_raster_{}.tif", count++);
  }
  ~MemoryFile() { VSIUnlink(name.c_str()); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  std::string name;
};

std::string crsOf(const std::string& wkt) {
  if (wkt.empty()) return {};
  const GdalReference reference(OSRNewSpatialReference(wkt.c_str()));
  const char* authority = OSRGetAuthorityName(reference.get(), nullptr);
  const char* code = OSRGetAuthorityCode(reference.get(), nullptr);
  return authority != nullptr && code != nullptr && std::string(authority) == "EPSG"
             ? std::string("EPSG:") + code
             : wkt;
}

std::map<std::string, std::string> metadataOf(GDALDatasetH dataset) {
  std::map<std::string, std::string> items;
  char** list = GDALGetMetadata(dataset, nullptr);
  for (int i = 0; i < CSLCount(list); ++i) {
    const std::string entry = list[i];
    const std::size_t equals = entry.find('=');
    if (equals != std::string::npos) items[entry.substr(0, equals)] = entry.substr(equals + 1);
  }
  return items;
}

}  // namespace

void writeFloatRaster(const fs::path& path, const FloatRaster& raster) {
  const QuietGdal quiet;
  const cv::Mat& values = raster.values;
  if (values.empty() || values.type() != CV_32FC1)
    throw RunError(path.string() + ": cannot be written: the raster has no Float32 values");
  const MemoryFile memory;
  const char* const options[] = {"TILED=YES", "COMPRESS=DEFLATE", "PREDICTOR=3", nullptr};
  {
    const GdalDataset dataset(GDALCreate(GDALGetDriverByName("GTiff"), memory.name.c_str(),
                                         values.cols, values.rows, 1, GDT_Float32, options));
    if (!dataset) failGdal(path, "cannot be written");
    for (const auto& [key, value] : raster.metadata)
      GDALSetMetadataItem(dataset.get(), key.c_str(), value.c_str(), nullptr);
    if (raster.geotransform) {
      std::array<double, 6> g = *raster.geotransform;
      GDALSetGeoTransform(dataset.get(), g.data());
    }
    if (!raster.crs_wkt_or_epsg.empty())
      GDALSetProjection(dataset.get(), gdalWkt(path, raster.crs_wkt_or_epsg).c_str());
    const GDALRasterBandH band = GDALGetRasterBand(dataset.get(), 1);
    cv::Mat copy = values.clone();  // GDAL takes a pointer to what may be written
    if (!cv::checkRange(copy)) GDALSetRasterNoDataValue(band, std::nan(""));
    if (GDALRasterIO(band, GF_Write, 0, 0, copy.cols, copy.rows, copy.data, copy.cols, copy.rows,
                     GDT_Float32, 0, static_cast<int>(copy.step)) != CE_None)
      failGdal(path, "cannot be written");
  }
  vsi_l_offset size = 0;
  const GByte* bytes = VSIGetMemFileBuffer(memory.name.c_str(), &size, FALSE);
  if (bytes == nullptr) failGdal(path, "cannot be written");
  AtomicFile file(path);
  file.write(bytes, size);
  file.commit();
}

FloatRaster readFloatRaster(const fs::path& path) {
  const QuietGdal quiet;
  const char* const drivers[] = {"GTiff", nullptr};
  const char* const siblings[] = {nullptr};  // do not look for sidecar files
  const GdalDataset dataset(
      GDALOpenEx(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, drivers, nullptr, siblings));
  if (!dataset) failGdal(path, "cannot be read as a TIFF");
  if (GDALGetRasterCount(dataset.get()) < 1) failGdal(path, "has no band");
  FloatRaster raster;
  raster.values.create(GDALGetRasterYSize(dataset.get()), GDALGetRasterXSize(dataset.get()),
                       CV_32FC1);
  const GDALRasterBandH band = GDALGetRasterBand(dataset.get(), 1);
  cv::Mat& v = raster.values;
  if (GDALRasterIO(band, GF_Read, 0, 0, v.cols, v.rows, v.data, v.cols, v.rows, GDT_Float32, 0,
                   static_cast<int>(v.step)) != CE_None)
    failGdal(path, "cannot be read");
  int has_no_data = 0;
  const auto no_data = static_cast<float>(GDALGetRasterNoDataValue(band, &has_no_data));
  if (has_no_data != 0 && !std::isnan(no_data))
    for (auto value = v.begin<float>(); value != v.end<float>(); ++value)
      if (std::equal_to<float>()(*value, no_data)) *value = std::numeric_limits<float>::quiet_NaN();
  raster.metadata = metadataOf(dataset.get());
  std::array<double, 6> g{};
  if (GDALGetGeoTransform(dataset.get(), g.data()) == CE_None) raster.geotransform = g;
  raster.crs_wkt_or_epsg = crsOf(GDALGetProjectionRef(dataset.get()));
  return raster;
}

}  // namespace cf
