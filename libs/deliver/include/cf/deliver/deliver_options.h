// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cf/base/options.h"

namespace cf {

/// Section [deliver].
struct DeliverOptions {
  bool html = true;             ///< report.html
  bool las = true;              ///< cloud/cloud.las
  bool dsm = true;              ///< dsm.tif
  bool orthophoto = true;       ///< orthophoto.tif
  double orthophoto_gsd_m = 0;  ///< 0 = half a matched pixel, but no finer than the photos
  bool handover = true;         ///< colmap/, shots.geojson, map.kml (hand_over.h)
  bool depth_maps = false;      ///< depth/<uav>/<photo>.tif

  void visit(OptionVisitor& v);
};

}  // namespace cf
