// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>

#include "cf/formats/geotiff.h"

namespace cf {

/// A GeoTIFF as GeoTiffWriter writes it, reduced to what a page can show.
struct ReducedRaster {
  cv::Mat values;    ///< CV_32FC1 heights, NaN for none; or CV_8UC4 BGR and 0 or 255 whether any
  GeoTiffGrid grid;  ///< of the reduced pixels
};

/// At most `most_px` on the longer side, averaged, from the overviews. Throws RunError naming the
/// path.
ReducedRaster readReduced(const std::filesystem::path& path, int most_px);

}  // namespace cf
