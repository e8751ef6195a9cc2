// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "cf/types/camera_model.h"
#include "cf/types/ids.h"

namespace cf {

/// One image of a rectified pair: a pinhole camera turned so that epipolar lines are rows.
/// Pixel (u, v) is the ray [(u - cx)/f, (v - cy)/f, 1] in the rectified frame.
struct RectifiedView {
  Eigen::Matrix3d R_rect_cam = Eigen::Matrix3d::Identity();
  double f = 0, cx = 0, cy = 0;  ///< [px]
  int width = 0, height = 0;     ///< [px]
};

/// Disparity of one virtual stereo pair and how to triangulate it. The reference view is where
/// the disparity lives: pixel (u, v) of it matches (u - d, v) of the partner view.
struct DepthFrame {
  FrameId reference, partner;
  RectifiedView reference_view, partner_view;
  CameraModel reference_camera, partner_camera;  ///< at matching, with their versions
  Eigen::Isometry3d T_reference_partner = Eigen::Isometry3d::Identity();  ///< at matching, metres
  cv::Mat disparity;   ///< CV_16UC1, 1/16 px plus 1 after disparity_offset; 0 = no match
  double disparity_offset_px = 0;  ///< d = (stored - 1) / 16 + disparity_offset_px
  cv::Mat confidence;  ///< CV_8UC1, 0..255
  cv::Mat colour;      ///< CV_8UC3 BGR of the reference view
};

}  // namespace cf
