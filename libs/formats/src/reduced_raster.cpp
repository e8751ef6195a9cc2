// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/reduced_raster.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

#include "gdal_support.h"

namespace cf {

ReducedRaster readReduced(const std::filesystem::path& path, int most_px) {
  const QuietGdal quiet;
  const GdalDataset dataset(GDALOpen(path.c_str(), GA_ReadOnly));
  std::array<double, 6> transform{};
  if (!dataset || GDALGetGeoTransform(dataset.get(), transform.data()) != CE_None)
    failGdal(path, "cannot be read");
  const int width = GDALGetRasterXSize(dataset.get()), height = GDALGetRasterYSize(dataset.get());
  const double step = std::max(1.0, static_cast<double>(std::max(width, height)) / most_px);
  const cv::Size size(std::max(1, static_cast<int>(std::lround(width / step))),
                      std::max(1, static_cast<int>(std::lround(height / step))));
  GDALRasterIOExtraArg how;
  INIT_RASTERIO_EXTRA_ARG(how);
  how.eResampleAlg = GRIORA_Average;
  const auto read = [&](GDALRasterBandH band, cv::Mat& into, GDALDataType type) {
    if (GDALRasterIOEx(band, GF_Read, 0, 0, width, height, into.data, size.width, size.height, type,
                       0, static_cast<GSpacing>(into.step), &how) != CE_None)
      failGdal(path, "cannot be read");
  };
  ReducedRaster out;
  out.grid = {size.width,   size.height,         transform[0],
              transform[3], transform[1] * step, GDALGetProjectionRef(dataset.get())};
  if (GDALGetRasterCount(dataset.get()) < 3) {
    out.values.create(size, CV_32FC1);
    read(GDALGetRasterBand(dataset.get(), 1), out.values, GDT_Float32);
    out.values.setTo(cv::Scalar(std::numeric_limits<float>::quiet_NaN()),
                     out.values <= static_cast<double>(GeoTiffWriter::kNoHeight));
    return out;
  }
  std::vector<cv::Mat> planes(4);
  for (cv::Mat& plane : planes) plane.create(size, CV_8UC1);
  for (int band = 0; band < 3; ++band)
    read(GDALGetRasterBand(dataset.get(), 3 - band), planes[static_cast<std::size_t>(band)],
         GDT_Byte);
  how.eResampleAlg = GRIORA_NearestNeighbour;
  read(GDALGetMaskBand(GDALGetRasterBand(dataset.get(), 1)), planes[3], GDT_Byte);
  cv::merge(planes, out.values);
  return out;
}

}  // namespace cf
