// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <opencv2/core/mat.hpp>

#include "cf/base/options.h"
#include "cf/simulate/scene.h"
#include "cf/simulate/true_camera.h"

namespace cf {

/// [photo]: how light becomes a photo.
struct PhotoOptions {
  int edge_samples = 4;          ///< rays per pixel where objects meet (1 elsewhere)
  double exposure_sigma = 0.05;  ///< change of brightness from photo to photo, fraction
  double vignetting = 0.25;      ///< loss of light in the corners, fraction
  double noise_sigma = 1.5;      ///< read noise in 8-bit steps; shot noise comes with it
  double exposure_s = 0.001;     ///< shutter time: motion blur
  double readout_s = 0;          ///< rolling shutter: from the first row to the last; 0 = global
  int jpeg_quality = 92;

  void visit(OptionVisitor& v);
};

/// A camera in motion. The pose is that of the middle of the photo: middle row, middle of exposure.
struct CameraMotion {
  Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();            ///< world
  Eigen::Vector3d angular_velocity_radps = Eigen::Vector3d::Zero();  ///< camera frame
};

/// The photo, 8-bit BGR, sRGB-like. Uses all threads; the result depends on the arguments alone.
cv::Mat takePhoto(const Scene& scene, const TrueCamera& camera, const CameraMotion& motion,
                  const PhotoOptions& options, std::uint64_t seed);

/// Exact depth along the optical axis [m] at the centres of the pixels (0,0), (step,0), (2 step,0)…
/// of the photo with motion.T_world_cam (CV_32FC1; 0 = nothing hit). Rolling shutter is honoured.
cv::Mat trueDepth(const Scene& scene, const TrueCamera& camera, const CameraMotion& motion,
                  const PhotoOptions& options, int step);

}  // namespace cf
