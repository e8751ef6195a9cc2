// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ceres/rotation.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "cf/align/pair_observation.h"
#include "cf/types/sim3.h"

namespace cf {

/// Parameters of a correction: rotation vector, translation [m], log of the scale; turning and
/// scaling about the segment's own centre, so that the three hardly depend on each other.
struct CorrectionBlock {
  double v[7] = {0, 0, 0, 0, 0, 0, 0};
  Eigen::Vector3d pivot = Eigen::Vector3d::Zero();

  Sim3 similarity() const {
    Sim3 S;
    S.scale = std::exp(v[6]);
    const Eigen::Vector3d w(v[0], v[1], v[2]);
    if (w.norm() > 0) S.rotation = Eigen::AngleAxisd(w.norm(), w.normalized()).toRotationMatrix();
    S.translation = pivot + Eigen::Vector3d(v[3], v[4], v[5]) - S.scale * (S.rotation * pivot);
    return S;
  }
};

/// The corrected position of a camera centre whose offset from the pivot is `arm`.
template <class T>
Eigen::Matrix<T, 3, 1> corrected(const T* block, const Eigen::Vector3d& pivot,
                                 const Eigen::Vector3d& arm) {
  const Eigen::Matrix<T, 3, 1> in = arm.cast<T>();
  Eigen::Matrix<T, 3, 1> turned;
  ceres::AngleAxisRotatePoint(block, in.data(), turned.data());
  const Eigen::Map<const Eigen::Matrix<T, 3, 1>> shift(block + 3);
  return ceres::exp(block[6]) * turned + shift + pivot.cast<T>();
}

/// Equation (9) for one observation, whitened: e_q (3), e_t across the direction (2), e_t along it
/// by the depths of a and of b (2).
struct RelativePoseResidual {
  static constexpr int kSize = 7;

  Eigen::Isometry3d T_world_a, T_world_b;  ///< before the correction
  Eigen::Vector3d pivot_a, pivot_b;
  Eigen::Quaterniond q_b_a;  ///< observed
  Eigen::Matrix3d basis;     ///< rows: the direction and two axes across it, in a
  double length_a_m = 0, length_b_m = 0;
  double weight_rotation = 0, weight_across = 0, weight_a = 0, weight_b = 0;  ///< 1/sigma

  RelativePoseResidual(const PairObservation& o, const Eigen::Isometry3d& T_a,
                       const Eigen::Isometry3d& T_b, const Eigen::Vector3d& centre_a,
                       const Eigen::Vector3d& centre_b)
      : T_world_a(T_a),
        T_world_b(T_b),
        pivot_a(centre_a),
        pivot_b(centre_b),
        q_b_a(Eigen::Matrix3d(o.pose.T_a_b.linear().transpose())) {
    basis.row(0) = o.direction_a.transpose();
    basis.row(1) = o.direction_a.unitOrthogonal().transpose();
    basis.row(2) = basis.row(0).cross(basis.row(1));
    constexpr double kSmallest = 1e-6;
    weight_rotation = 1 / std::max(o.rotation_sigma_rad, kSmallest);
    weight_across = 1 / std::max(o.across_sigma_m, kSmallest);
    length_a_m = o.by_depth_a.length_m;
    length_b_m = o.by_depth_b.length_m;
    if (o.by_depth_a.sigma_m > 0) weight_a = 1 / std::max(o.by_depth_a.sigma_m, kSmallest);
    if (o.by_depth_b.sigma_m > 0) weight_b = 1 / std::max(o.by_depth_b.sigma_m, kSmallest);
    if (weight_a == 0 && weight_b == 0) {  // only equation (8) knows the length, half to double
      length_a_m = o.gnss_length_m;
      weight_a = 1 / std::max(0.5 * o.gnss_length_m, kSmallest);
    }
  }

  template <class T>
  bool operator()(const T* block_a, const T* block_b, T* residual) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    const auto rotation = [](const T* block, const Eigen::Isometry3d& T_world_cam) {
      T q[4];
      ceres::AngleAxisToQuaternion(block, q);
      return Eigen::Quaternion<T>(q[0], q[1], q[2], q[3]) *
             Eigen::Quaterniond(T_world_cam.linear()).cast<T>();
    };
    const Eigen::Quaternion<T> q_a = rotation(block_a, T_world_a),
                               q_b = rotation(block_b, T_world_b);
    // e_q: what is left of the observed rotation in b's own frame.
    const Eigen::Quaternion<T> left = q_b_a.cast<T>() * (q_a.conjugate() * q_b);
    const T wxyz[4] = {left.w(), left.x(), left.y(), left.z()};
    Vector e_q;
    ceres::QuaternionToAngleAxis(wxyz, e_q.data());
    // e_t, in a's frame.
    const Vector apart =
        corrected(block_b, pivot_b, Eigen::Vector3d(T_world_b.translation() - pivot_b)) -
        corrected(block_a, pivot_a, Eigen::Vector3d(T_world_a.translation() - pivot_a));
    const Vector t = basis.cast<T>() * (q_a.conjugate() * apart);
    for (int k = 0; k < 3; ++k) residual[k] = weight_rotation * e_q[k];
    residual[3] = weight_across * t[1];
    residual[4] = weight_across * t[2];
    residual[5] = weight_a * (t[0] - ceres::exp(block_a[6]) * length_a_m);
    residual[6] = weight_b * (t[0] - ceres::exp(block_b[6]) * length_b_m);
    return true;
  }

  /// Metres and radians between the observation and the corrected poses.
  std::pair<double, double> discrepancy(const double* block_a, const double* block_b) const {
    double r[kSize];
    (*this)(block_a, block_b, r);
    const double angle = Eigen::Vector3d(r[0], r[1], r[2]).norm() / weight_rotation;
    // The length that both photos agree on best.
    const double wa = weight_a * weight_a, wb = weight_b * weight_b;
    const double along =
        ((wa > 0 ? r[5] * weight_a : 0) + (wb > 0 ? r[6] * weight_b : 0)) / (wa + wb);
    const double across = std::hypot(r[3], r[4]) / weight_across;
    return {std::hypot(across, along), angle};
  }
};

/// A fix against the corrected camera centre, through the UAV's bias.
struct FixResidual {
  Eigen::Vector3d arm, pivot, fix, sigma;

  template <class T>
  bool operator()(const T* block, const T* bias, T* residual) const {
    const Eigen::Matrix<T, 3, 1> centre = corrected(block, pivot, arm);
    for (int k = 0; k < 3; ++k) residual[k] = (centre[k] + bias[k] - fix[k]) / sigma[k];
    return true;
  }
};

}  // namespace cf
