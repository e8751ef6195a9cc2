// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

namespace cf {

/// Similarity transform S_a_b: p_a = scale * rotation * p_b + translation.
struct Sim3 {
  double scale = 1;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator*(const Eigen::Vector3d& p) const {
    return scale * (rotation * p) + translation;
  }
  Sim3 operator*(const Sim3& o) const {
    return {scale * o.scale, rotation * o.rotation, (*this) * o.translation};
  }
  Sim3 inverse() const {
    const Eigen::Matrix3d R = rotation.transpose();
    return {1 / scale, R, -(R * translation) / scale};
  }
  /// The pose of a camera whose centre and axes are carried along: T_a_cam of T_b_cam.
  Eigen::Isometry3d carry(const Eigen::Isometry3d& T_b_cam) const {
    Eigen::Isometry3d T_a_cam = Eigen::Isometry3d::Identity();
    T_a_cam.linear() = rotation * T_b_cam.linear();
    T_a_cam.translation() = (*this) * Eigen::Vector3d(T_b_cam.translation());
    return T_a_cam;
  }
};

/// The S_a_b of a given scale that carries T_b_cam to T_a_cam.
inline Sim3 similarityAt(double scale, const Eigen::Isometry3d& T_a_cam,
                         const Eigen::Isometry3d& T_b_cam) {
  Sim3 S_a_b;
  S_a_b.scale = scale;
  S_a_b.rotation = T_a_cam.linear() * T_b_cam.linear().transpose();
  S_a_b.translation =
      T_a_cam.translation() - scale * (S_a_b.rotation * Eigen::Vector3d(T_b_cam.translation()));
  return S_a_b;
}

}  // namespace cf
