// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cf/geometry/rectification.h"
#include "cf/types/depth_frame.h"
#include "cf/types/map_point.h"

namespace cf {

struct DepthTriangulationOptions {
  int stride = 1;          ///< take every stride-th pixel of every stride-th row
  int min_confidence = 1;  ///< of 255
  double disparity_sigma_px = 0.3;
};

/// The points of a depth frame, which must hold its colour, with the poses and cameras as known
/// now. Both rays of each match are turned from the rectified views to their photos; where a camera
/// has been refined since matching, they go through the old model's distortion back to the photo's
/// pixel and out through the new one. The point is the middle of the shortest segment between the
/// two rays, relative to the reference camera.
/// Weight: inverse variance along the reference ray [1/m^2] by sigma_Z = Z^2 / (f b) sigma_d, times
/// confidence / 255. Rays that meet behind a camera or nowhere give no point.
MapPoints triangulateDepth(const DepthFrame& frame, const PosedCamera& reference_now,
                           const PosedCamera& partner_now,
                           const DepthTriangulationOptions& options = {});

}  // namespace cf
