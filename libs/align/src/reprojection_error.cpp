// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "reprojection_error.h"

namespace cf {

Lens lensOf(const CameraModel& c) {
  return {c.fx / c.width, c.k1, c.k2, c.p1, c.p2, (c.cx + 0.5) / c.width, (c.cy + 0.5) / c.width};
}

CameraModel withLens(CameraModel camera, const Lens& lens) {
  const double aspect = camera.fy / camera.fx;
  camera.fx = lens[0] * camera.width;
  camera.fy = aspect * camera.fx;
  camera.k1 = lens[1];
  camera.k2 = lens[2];
  camera.p1 = lens[3];
  camera.p2 = lens[4];
  camera.cx = lens[5] * camera.width - 0.5;
  camera.cy = lens[6] * camera.width - 0.5;
  return camera;
}

PoseBlock poseBlockOf(const Eigen::Isometry3d& T_world_cam) {
  const Eigen::Quaterniond q(T_world_cam.linear());
  const Eigen::Vector3d t = T_world_cam.translation();
  return {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()};
}

Eigen::Isometry3d poseOf(const PoseBlock& block) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() =
      Eigen::Quaterniond(block[0], block[1], block[2], block[3]).normalized().toRotationMatrix();
  T.translation() = Eigen::Vector3d(block[4], block[5], block[6]);
  return T;
}

ReprojectionError::ReprojectionError(const Eigen::Vector2d& pixel, const CameraModel& camera,
                                     double sigma_px)
    : x_(pixel.x() + 0.5),
      y_(pixel.y() + 0.5),
      width_(camera.width),
      aspect_(camera.fy / camera.fx),
      k3_(camera.k3),
      inverse_sigma_(1 / sigma_px) {}

bool ReprojectionError::Evaluate(double const* const* parameters, double* residuals,
                                 double** jacobians) const {
  const double* pose = parameters[0];
  const double* lens = parameters[2];
  const double w = pose[0];
  const Eigen::Vector3d v(pose[1], pose[2], pose[3]);
  const Eigen::Vector3d d = Eigen::Map<const Eigen::Vector3d>(parameters[1]) -
                            Eigen::Map<const Eigen::Vector3d>(pose + 4);
  // R^T d of a unit quaternion.
  const Eigen::Vector3d vxd = v.cross(d);
  const Eigen::Vector3d c = d - 2 * w * vxd + 2 * v.cross(vxd);
  if (!(c.z() > 1e-6)) return false;
  const double z = 1 / c.z(), x = c.x() * z, y = c.y() * z, r2 = x * x + y * y;
  const double k1 = lens[1], k2 = lens[2], p1 = lens[3], p2 = lens[4];
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3_));
  const double xd = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
  const double yd = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
  const double fx = inverse_sigma_ * lens[0] * width_, fy = fx * aspect_;
  residuals[0] = fx * xd + inverse_sigma_ * (lens[5] * width_ - x_);
  residuals[1] = fy * yd + inverse_sigma_ * (lens[6] * width_ - y_);
  if (jacobians == nullptr) return true;

  // By camera coordinates: focal length, distortion, perspective.
  const double slope = k1 + r2 * (2 * k2 + r2 * 3 * k3_);  // of `radial` by r2
  const double xx = radial + 2 * x * x * slope + 2 * p1 * y + 6 * p2 * x;
  const double xy = 2 * x * y * slope + 2 * p1 * x + 2 * p2 * y;
  const double yy = radial + 2 * y * y * slope + 6 * p1 * y + 2 * p2 * x;
  Eigen::Matrix<double, 2, 3> by_camera;
  by_camera << fx * z * xx, fx * z * xy, -fx * z * (x * xx + y * xy),  //
      fy * z * xy, fy * z * yy, -fy * z * (x * xy + y * yy);

  if (jacobians[0] != nullptr || jacobians[1] != nullptr) {
    Eigen::Matrix3d R_cam_world = Eigen::Quaterniond(w, -v.x(), -v.y(), -v.z()).toRotationMatrix();
    const Eigen::Matrix<double, 2, 3> by_point = by_camera * R_cam_world;
    if (jacobians[0] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 2, kPose, Eigen::RowMajor>> J(jacobians[0]);
      Eigen::Matrix3d by_v =
          2 * (v.dot(d) * Eigen::Matrix3d::Identity() + v * d.transpose() - 2 * d * v.transpose());
      by_v +=
          2 * w *
          (Eigen::Matrix3d() << 0, -d.z(), d.y(), d.z(), 0, -d.x(), -d.y(), d.x(), 0).finished();
      J.col(0) = by_camera * (-2 * vxd);
      J.middleCols<3>(1) = by_camera * by_v;
      J.rightCols<3>() = -by_point;
    }
    if (jacobians[1] != nullptr)
      Eigen::Map<Eigen::Matrix<double, 2, 3, Eigen::RowMajor>>{jacobians[1]} = by_point;
  }
  if (jacobians[2] != nullptr) {
    Eigen::Map<Eigen::Matrix<double, 2, kLens, Eigen::RowMajor>> J(jacobians[2]);
    J << inverse_sigma_ * width_ * xd, fx * x * r2, fx * x * r2 * r2, fx * 2 * x * y,
        fx * (r2 + 2 * x * x), inverse_sigma_ * width_, 0,  //
        inverse_sigma_ * width_ * aspect_ * yd, fy * y * r2, fy * y * r2 * r2,
        fy * (r2 + 2 * y * y), fy * 2 * x * y, 0, inverse_sigma_ * width_;
  }
  return true;
}

}  // namespace cf
