// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/types/image_frame.h"

#include <Eigen/Geometry>
#include <cmath>

namespace cf {

Eigen::Matrix3d rotationWorldCam(const GimbalAttitude& a) {
  constexpr double kDeg = M_PI / 180.0;
  // Level camera looking north: x right = east, y down = -up, z forward = north.
  Eigen::Matrix3d R_ned_cam;  // NED: x north, y east, z down
  R_ned_cam << 0, 0, 1,
               1, 0, 0,
               0, 1, 0;
  Eigen::Matrix3d R_enu_ned;
  R_enu_ned << 0, 1, 0,
               1, 0, 0,
               0, 0, -1;
  const Eigen::Matrix3d R_ned_body =
      (Eigen::AngleAxisd(a.yaw_deg * kDeg, Eigen::Vector3d::UnitZ()) *
       Eigen::AngleAxisd(a.pitch_deg * kDeg, Eigen::Vector3d::UnitY()) *
       Eigen::AngleAxisd(a.roll_deg * kDeg, Eigen::Vector3d::UnitX()))
          .toRotationMatrix();
  return R_enu_ned * R_ned_body * R_ned_cam;
}

}  // namespace cf
