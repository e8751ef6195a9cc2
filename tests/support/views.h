// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

namespace cf::support {

constexpr double kDegree = M_PI / 180;

/// T_world_cam of a camera that looks down, its photo's top towards north, turned by yaw
/// (counter-clockwise from above), its axis lifted by pitch and tipped by roll.
inline Eigen::Isometry3d nadirPose(const Eigen::Vector3d& centre, double yaw_deg,
                                   double pitch_deg = 0, double roll_deg = 0) {
  Eigen::Matrix3d nadir;
  nadir << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(yaw_deg * kDegree, Eigen::Vector3d::UnitZ()) * nadir *
               Eigen::AngleAxisd(pitch_deg * kDegree, Eigen::Vector3d::UnitX()) *
               Eigen::AngleAxisd(roll_deg * kDegree, Eigen::Vector3d::UnitY());
  T.translation() = centre;
  return T;
}

inline double rotationErrorDeg(const Eigen::Matrix3d& p, const Eigen::Matrix3d& q) {
  return Eigen::AngleAxisd(Eigen::Matrix3d(p.transpose() * q)).angle() / kDegree;
}
inline double rotationErrorDeg(const Eigen::Isometry3d& p, const Eigen::Isometry3d& q) {
  return rotationErrorDeg(Eigen::Matrix3d(p.linear()), Eigen::Matrix3d(q.linear()));
}

inline double angleDeg(const Eigen::Vector3d& u, const Eigen::Vector3d& v) {
  return std::atan2(u.cross(v).norm(), u.dot(v)) / kDegree;
}

/// Value below which a share of the values lies.
inline double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

}  // namespace cf::support
