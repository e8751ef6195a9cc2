// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/simulate/true_camera.h"

#include <Eigen/Dense>

namespace cf {
namespace {

/// Displacement by the lens of a point of the plane z = 1.
Eigen::Vector2d bend(const TrueCamera& c, const Eigen::Vector2d& n) {
  const double r2 = n.squaredNorm();
  const double radial = r2 * (c.k1 + r2 * (c.k2 + r2 * c.k3));
  const double xy = n.x() * n.y();
  return radial * n + Eigen::Vector2d(2 * c.p1 * xy + c.p2 * (r2 + 2 * n.x() * n.x()),
                                      2 * c.p2 * xy + c.p1 * (r2 + 2 * n.y() * n.y()));
}

}  // namespace

Eigen::Vector2d TrueCamera::pixelOf(const Eigen::Vector3d& p_cam) const {
  const Eigen::Vector2d n = p_cam.head<2>() / p_cam.z();
  return focal * (n + bend(*this, n)) + Eigen::Vector2d(cx, cy);
}

Eigen::Vector3d TrueCamera::rayThrough(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d target = (pixel - Eigen::Vector2d(cx, cy)) / focal;
  // A damped fixed-point iteration would do for weak lenses; Newton with a numerical Jacobian does
  // for all that do not fold over.
  Eigen::Vector2d n = target;
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector2d error = n + bend(*this, n) - target;
    if (error.norm() < 1e-13) break;
    constexpr double kStep = 1e-6;
    Eigen::Matrix2d jacobian = Eigen::Matrix2d::Identity();
    for (int a = 0; a < 2; ++a) {
      Eigen::Vector2d d = Eigen::Vector2d::Zero();
      d[a] = kStep;
      jacobian.col(a) += (bend(*this, n + d) - bend(*this, n - d)) / (2 * kStep);
    }
    n -= jacobian.inverse() * error;
  }
  return {n.x(), n.y(), 1};
}

}  // namespace cf
