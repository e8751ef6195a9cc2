// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>

#include "cf/densify/densify.h"
#include "cf/formats/float_raster.h"
#include "cf/types/ids.h"
#include "cf/types/map_point.h"

namespace cf {

/// A depth map for each photo, made of the points that its stereo pairs give: depth along the
/// optical axis [m] on the photo's own (distorted) pixels, every `step`-th of them about as many as
/// are matched. Value (column i, row j) belongs to photo pixel (i * step, j * step); 0 = nothing.
///
/// Points fall on the nearest pixel. There, depths within 1 % of each other are averaged by weight;
/// of two surfaces the one with the greater weight so far stays. Points must come in a fixed order.
class DepthMaps {
 public:
  /// `megapixels` matched, as [densify] says.
  explicit DepthMaps(double megapixels) : megapixels_(megapixels) {}

  void add(const DenseView& photo, const MapPoints& points);
  /// The photo's map with STEP in its metadata, nothing if it has no point; it is forgotten here.
  std::optional<FloatRaster> take(FrameId photo);

 private:
  struct Map {
    int step = 1;
    cv::Mat depth, weight;  ///< CV_32FC1
  };
  Map emptyMap(const CameraModel& camera) const;

  double megapixels_;
  std::map<FrameId, Map> maps_;
};

}  // namespace cf
