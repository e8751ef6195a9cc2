// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "cf/geodesy/grid_frame.h"
#include "cf/types/camera_model.h"

namespace cf {

/// A photo as the orthophoto needs it.
struct OrthoPhoto {
  Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
  CameraModel camera;  ///< of the original size
  int lens = 0;        ///< photos of one camera share a fall-off of brightness to the corners
  cv::Mat thumbnail;   ///< CV_8UC3, the whole photo some hundred pixels wide; empty: it is not used
};

/// A true orthophoto: every pixel from the photo that sees its place most steeply and unhidden.
///
/// `dsm` is the surface (DsmBuilder) on which photos are laid; holes in it are bridged smoothly for
/// the picture where data surround them. Photos are brought to one brightness: a gain for each,
/// a fall-off to the corners for each lens, and, over tens of metres, the mean of all photos that
/// see a place. Next to seams photos are blended over about a metre, less than what they differ in.
///
/// `decode` gives photo i in colour at any scale, empty where it cannot be read; it is called from
/// several threads. Each photo is decoded once, or again where more of them are needed side by side
/// than `crops_mb` hold. Pixels have about `gsd_m`: a cell of the surface holds a whole number of
/// them, or they a whole number of cells. No data: the mask. Throws RunError naming the path.
void writeOrthophoto(const std::filesystem::path& path, const std::filesystem::path& dsm,
                     const GridFrame& grid, const std::vector<OrthoPhoto>& photos,
                     const std::function<cv::Mat(std::size_t)>& decode, double gsd_m,
                     int crops_mb = 300);

/// What OrthoPhoto::thumbnail is made with.
cv::Mat orthoThumbnail(const cv::Mat& photo);

}  // namespace cf
