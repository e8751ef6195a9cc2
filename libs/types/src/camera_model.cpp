// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/types/camera_model.h"

#include <cmath>

namespace cf {

Eigen::Vector2d CameraModel::project(const Eigen::Vector3d& p_cam) const {
  return distort(p_cam.head<2>() / p_cam.z());
}

Eigen::Vector2d CameraModel::distort(const Eigen::Vector2d& n) const {
  const double x = n.x(), y = n.y(), r2 = n.squaredNorm();
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double xd = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
  const double yd = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
  return {fx * xd + cx, fy * yd + cy};
}

Eigen::Vector2d CameraModel::undistort(const Eigen::Vector2d& pixel) const {
  const double xd = (pixel.x() - cx) / fx, yd = (pixel.y() - cy) / fy;
  double x = xd, y = yd;
  for (int i = 0; i < 30; ++i) {
    const double r2 = x * x + y * y;
    const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
    const double slope = 2 * (k1 + r2 * (2 * k2 + r2 * 3 * k3));  // of radial along r, over r
    const double ex = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x) - xd;
    const double ey = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y - yd;
    // Jacobian [a b; b c] of the distortion.
    const double a = radial + x * x * slope + 2 * p1 * y + 6 * p2 * x;
    const double b = x * y * slope + 2 * p1 * x + 2 * p2 * y;
    const double c = radial + y * y * slope + 6 * p1 * y + 2 * p2 * x;
    const double determinant = a * c - b * b;
    // A strong barrel distortion folds over outside what the lens sees; do not follow it there.
    if (determinant < 1e-3) break;
    const double dx = (c * ex - b * ey) / determinant;
    const double dy = (a * ey - b * ex) / determinant;
    x -= dx;
    y -= dy;
    if (std::abs(dx) + std::abs(dy) < 1e-14) break;
  }
  return {x, y};
}

CameraModel CameraModel::scaled(int new_width, int new_height) const {
  CameraModel out = *this;
  const double sx = static_cast<double>(new_width) / width;
  const double sy = static_cast<double>(new_height) / height;
  out.width = new_width;
  out.height = new_height;
  out.fx = fx * sx;
  out.fy = fy * sy;
  out.cx = (cx + 0.5) * sx - 0.5;
  out.cy = (cy + 0.5) * sy - 0.5;
  out.focal_sigma = focal_sigma * sx;
  return out;
}

}  // namespace cf
