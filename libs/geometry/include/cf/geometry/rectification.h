// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "cf/base/result.h"
#include "cf/types/camera_model.h"
#include "cf/types/depth_frame.h"

namespace cf {

struct PosedCamera {
  Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
  CameraModel camera;
};

/// How large the rectified pair becomes and where the scene is.
struct RectificationRequest {
  double megapixels = 1.5;  ///< of the common area; the resolution never exceeds the photos'
  /// Of the scene along the reference camera's z axis; lays out the common area. 0 < near <= far.
  double near_depth_m = 0, far_depth_m = 0;
  /// Of the disparity range: how far the scene may reach beyond that. The same if 0.
  double search_near_depth_m = 0, search_far_depth_m = 0;
  double min_overlap = 0.1;  ///< share of the reference photo that the partner must see
};

/// Two virtual views whose rows are epipolar lines. Both look the same way and the baseline is
/// their +x axis, so that a point nearer by has a larger disparity u_reference - u_partner. The
/// partner's cx is its own: the nearest depth has disparity 0 or less, the farthest
/// min_disparity_px, and the partner view is wider than the reference by that range.
struct RectifiedPair {
  RectifiedView reference, partner;
  Eigen::Isometry3d T_reference_partner = Eigen::Isometry3d::Identity();  ///< of the cameras
  double baseline_m = 0;
  double overlap = 0;        ///< share of the reference photo seen by the partner
  int min_disparity_px = 0;  ///< of the farthest depth, negative
  int max_disparity_px = 0;  ///< of the nearest depth

  /// Depth along the rectified z axis [m] of a disparity; infinite or negative beyond infinity.
  double depth(double disparity_px) const {
    return reference.f * baseline_m / (disparity_px - (reference.cx - partner.cx));
  }
  double disparity(double depth_m) const {
    return reference.f * baseline_m / depth_m + (reference.cx - partner.cx);
  }
};

/// Rectification along the true baseline, for any direction of it: x along the baseline, z the mean
/// optical axis made orthogonal to x. The crop is the box of what both photos see between the near
/// and the far depth. Failures: "no_baseline", "forward_motion" (baseline within 45 degrees of the
/// optical axes), "diverging_views", "little_overlap".
Result<RectifiedPair> rectifyPair(const PosedCamera& reference, const PosedCamera& partner,
                                  const RectificationRequest& request);

/// Where each pixel of a rectified view comes from: the two maps of cv::remap (CV_16SC2 and
/// CV_16UC1) with the lens distortion folded in, and where that is inside the photo (CV_8UC1, 255
/// or 0).
struct RemapTable {
  cv::Mat fixed_xy, fraction;
  cv::Mat inside;
};

/// Of the rows in `strip` alone, if given: a whole table is several times as large as the image.
/// `image_camera` is the camera of the image to be sampled: camera.scaled(image.cols, image.rows).
/// Exact on a grid of 8 px and bilinear between, then rounded to cv::remap's 1/32 px.
RemapTable remapTable(const RectifiedView& view, const CameraModel& image_camera,
                      cv::Range strip = cv::Range::all());

}  // namespace cf
