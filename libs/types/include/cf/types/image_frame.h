// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

#include "cf/base/time.h"
#include "cf/types/camera_model.h"
#include "cf/types/ids.h"

namespace cf {

/// Attitude of the camera as a gimbal tags it, DJI's convention, degrees: yaw from north
/// clockwise, pitch -90 looking straight down, 0 at the horizon, roll about the optical axis.
struct GimbalAttitude {
  double yaw_deg = 0;
  double pitch_deg = -90;
  double roll_deg = 0;
};

/// T_world_cam's rotation for a gimbal attitude: ENU from camera (x right, y down, z forward).
/// yaw 0, pitch -90: the photo's top is north.
Eigen::Matrix3d rotationWorldCam(const GimbalAttitude& attitude);

/// One photo as recorded, before any processing.
struct ImageFrame {
  FrameId id;
  TimeNs time = 0;
  std::string name;             ///< original base name with extension
  std::filesystem::path file;   ///< absolute
  CameraModel camera;           ///< for the original size of this photo
  std::optional<GimbalAttitude> attitude;
  std::optional<double> height_above_ground_m;  ///< as tagged (above take-off)
  /// Decoded BGR photo, possibly reduced: camera.scaled(image.cols, image.rows) is its camera.
  cv::Mat image;
};

}  // namespace cf
