// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/geotiff.h"

#include <cpl_conv.h>
#include <cpl_string.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

#include "cf/base/disk.h"
#include "cf/base/error.h"
#include "gdal_support.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

/// GDAL's own default is a twentieth of the machine's memory.
constexpr GIntBig kCacheBytes = 64 << 20;
constexpr int kSmallestOverview_px = 256;

/// A setting of GDAL's for this thread while it lives.
class GdalSetting {
 public:
  GdalSetting(const char* key, const char* value) : key_(key) {
    CPLSetThreadLocalConfigOption(key, value);
  }
  ~GdalSetting() { CPLSetThreadLocalConfigOption(key_, nullptr); }
  GdalSetting(const GdalSetting&) = delete;
  GdalSetting& operator=(const GdalSetting&) = delete;

 private:
  const char* key_;
};

}  // namespace

struct GeoTiffWriter::Handle {
  GdalDataset dataset;
};

GeoTiffWriter::GeoTiffWriter(const fs::path& path, Kind kind, const GeoTiffGrid& grid,
                             const std::map<std::string, std::string>& metadata)
    : path_(path),
      temporary_(path.string() + ".tmp"),
      kind_(kind),
      handle_(std::make_unique<Handle>()) {
  const QuietGdal quiet;
  const GdalSetting inside("GDAL_TIFF_INTERNAL_MASK", "YES");
  GDALSetCacheMax64(kCacheBytes);
  const std::string wkt = grid.crs.empty() ? std::string() : gdalWkt(path_, grid.crs);
  const bool heights = kind == Kind::kHeights;
  std::vector<std::string> options = {"TILED=YES", fmt::format("BLOCKXSIZE={}", kTile_px),
                                      fmt::format("BLOCKYSIZE={}", kTile_px), "BIGTIFF=IF_SAFER",
                                      "SPARSE_OK=TRUE"};
  if (heights)
    options.insert(options.end(), {"COMPRESS=DEFLATE", "PREDICTOR=3", "ZLEVEL=4"});
  else
    options.insert(options.end(), {"COMPRESS=JPEG", "PHOTOMETRIC=YCBCR", "JPEG_QUALITY=92"});
  std::vector<const char*> list;
  for (const std::string& option : options) list.push_back(option.c_str());
  list.push_back(nullptr);
  GdalDataset& dataset = handle_->dataset;
  dataset.reset(GDALCreate(GDALGetDriverByName("GTiff"), temporary_.c_str(), grid.width,
                           grid.height, heights ? 1 : 3, heights ? GDT_Float32 : GDT_Byte,
                           list.data()));
  if (!dataset) failGdal(path_, "cannot be written");
  std::array<double, 6> transform = {grid.left_m, grid.cell_m, 0, grid.top_m, 0, -grid.cell_m};
  GDALSetGeoTransform(dataset.get(), transform.data());
  if (!wkt.empty()) GDALSetProjection(dataset.get(), wkt.c_str());
  for (const auto& [key, value] : metadata)
    GDALSetMetadataItem(dataset.get(), key.c_str(), value.c_str(), nullptr);
  if (heights) {
    const GDALRasterBandH band = GDALGetRasterBand(dataset.get(), 1);
    GDALSetRasterNoDataValue(band, static_cast<double>(kNoHeight));
    GDALSetRasterUnitType(band, "m");
    GDALSetDescription(band, "height");
  } else if (GDALCreateDatasetMaskBand(dataset.get(), GMF_PER_DATASET) != CE_None) {
    failGdal(path_, "cannot be written");
  }
}

GeoTiffWriter::~GeoTiffWriter() {
  if (!handle_->dataset) return;
  const QuietGdal quiet;
  handle_->dataset.reset();
  std::error_code ignored;
  fs::remove(temporary_, ignored);
}

void GeoTiffWriter::write(int column, int row, const cv::Mat& window) {
  const QuietGdal quiet;
  const GDALDatasetH dataset = handle_->dataset.get();
  const int width = window.cols, height = window.rows;
  if (kind_ == Kind::kHeights) {
    if (window.type() != CV_32FC1) throw RunError(path_.string() + ": heights must be CV_32FC1");
    cv::Mat values = window.clone();
    cv::patchNaNs(values, static_cast<double>(kNoHeight));
    if (GDALRasterIO(GDALGetRasterBand(dataset, 1), GF_Write, column, row, width, height,
                     values.data, width, height, GDT_Float32, 0,
                     static_cast<int>(values.step)) != CE_None)
      failGdal(path_, "cannot be written");
    return;
  }
  if (window.type() != CV_8UC4) throw RunError(path_.string() + ": colours must be CV_8UC4");
  cv::Mat pixels = window.isContinuous() ? window : window.clone();
  const int line = static_cast<int>(pixels.step);
  std::array<int, 3> bands = {3, 2, 1};  // blue comes first
  if (GDALDatasetRasterIO(dataset, GF_Write, column, row, width, height, pixels.data, width, height,
                          GDT_Byte, 3, bands.data(), 4, line, 1) != CE_None)
    failGdal(path_, "cannot be written");
  const GDALRasterBandH mask = GDALGetMaskBand(GDALGetRasterBand(dataset, 1));
  if (GDALRasterIO(mask, GF_Write, column, row, width, height, pixels.data + 3, width, height,
                   GDT_Byte, 4, line) != CE_None)
    failGdal(path_, "cannot be written");
  // Otherwise the order in the file hangs on what else is read through GDAL's cache.
  GDALFlushCache(dataset);
}

void GeoTiffWriter::close() {
  const QuietGdal quiet;
  const GdalSetting inside("GDAL_TIFF_INTERNAL_MASK", "YES");
  const GdalSetting quality("JPEG_QUALITY_OVERVIEW", "85");
  const GdalSetting sparse("SPARSE_OK_OVERVIEW", "ON");
  const GdalSetting tile("GDAL_TIFF_OVR_BLOCKSIZE", "512");
  const GDALDatasetH dataset = handle_->dataset.get();
  std::vector<int> levels;
  const int size = std::max(GDALGetRasterXSize(dataset), GDALGetRasterYSize(dataset));
  for (int level = 2; size > kSmallestOverview_px * level / 2; level *= 2) levels.push_back(level);
  GDALFlushCache(dataset);
  if (!levels.empty() && GDALBuildOverviews(dataset, "AVERAGE", static_cast<int>(levels.size()),
                                            levels.data(), 0, nullptr, nullptr, nullptr) != CE_None)
    failGdal(path_, "cannot be given overviews");
  CPLErrorReset();
  GDALFlushCache(dataset);
  handle_->dataset.reset();
  std::error_code error;
  if (CPLGetLastErrorType() >= CE_Failure || !syncFile(temporary_)) {
    fs::remove(temporary_, error);
    failGdal(path_, "cannot be written");
  }
  fs::rename(temporary_, path_, error);
  if (error) throw RunError(path_.string() + ": cannot be replaced: " + error.message());
}

struct GeoTiffReader::Handle {
  GdalDataset dataset;
};

GeoTiffReader::GeoTiffReader(const fs::path& path)
    : path_(path), handle_(std::make_unique<Handle>()) {
  const QuietGdal quiet;
  GdalDataset& dataset = handle_->dataset;
  dataset.reset(GDALOpen(path.c_str(), GA_ReadOnly));
  if (!dataset) failGdal(path, "cannot be read");
  std::array<double, 6> transform{};
  if (GDALGetGeoTransform(dataset.get(), transform.data()) != CE_None)
    throw RunError(path.string() + ": cannot be read: it says not where it lies");
  grid_ = {GDALGetRasterXSize(dataset.get()),
           GDALGetRasterYSize(dataset.get()),
           transform[0],
           transform[3],
           transform[1],
           GDALGetProjectionRef(dataset.get())};
}

GeoTiffReader::~GeoTiffReader() = default;

cv::Mat GeoTiffReader::heights(const cv::Rect& window) const {
  const QuietGdal quiet;
  cv::Mat values(window.size(), CV_32FC1, cv::Scalar(std::numeric_limits<float>::quiet_NaN()));
  const cv::Rect inside = window & cv::Rect(0, 0, grid_.width, grid_.height);
  if (inside.empty()) return values;
  const GDALRasterBandH band = GDALGetRasterBand(handle_->dataset.get(), 1);
  cv::Mat part = values(inside - window.tl());
  if (GDALRasterIO(band, GF_Read, inside.x, inside.y, inside.width, inside.height, part.data,
                   inside.width, inside.height, GDT_Float32, 0,
                   static_cast<int>(part.step)) != CE_None)
    failGdal(path_, "cannot be read");
  part.setTo(cv::Scalar(std::numeric_limits<float>::quiet_NaN()),
             part <= static_cast<double>(GeoTiffWriter::kNoHeight));
  return values;
}

}  // namespace cf
