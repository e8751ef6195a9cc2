// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/deliver/deliver_options.h"

namespace cf {

void DeliverOptions::visit(OptionVisitor& v) {
  v.flag("html", html, "write report.html");
  v.flag("las", las,
         "write cloud/cloud.las: the dense cloud as LAS 1.4 in UTM; user data = depth frames that "
         "saw a point");
  v.flag("dsm", dsm, "write dsm.tif: the height of the uppermost surface [m] on a raster in UTM");
  v.flag("orthophoto", orthophoto, "write orthophoto.tif: the photos laid on that surface");
  v.number("orthophoto_gsd_m", orthophoto_gsd_m, {0, 100},
           "side of its pixels [m], about; 0 = half a matched pixel, but no finer than the photos");
  v.flag("handover", handover,
         "write colmap/ (COLMAP's text model), shots.geojson (as OpenDroneMap's) and map.kml for "
         "other programs");
  v.flag("depth_maps", depth_maps,
         "write depth/<uav>/<photo>.tif: depth along the optical axis [m] on every STEP-th pixel "
         "of the photo, 0 = nothing");
}

}  // namespace cf
