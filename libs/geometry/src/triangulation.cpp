// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/geometry/triangulation.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

namespace cf {
namespace {

Eigen::Vector3d rayOf(const Sight& s) {
  return (s.T_world_cam.linear() * s.normalized.homogeneous()).normalized();
}

}  // namespace

double reprojectionError(const Sight& sight, const Eigen::Vector3d& p_world) {
  const Eigen::Vector3d p =
      sight.T_world_cam.linear().transpose() * (p_world - sight.T_world_cam.translation());
  if (p.z() <= 0) return std::numeric_limits<double>::infinity();
  return (p.hnormalized() - sight.normalized).norm();
}

Result<Triangulated> triangulate(const std::vector<Sight>& sights) {
  if (sights.size() < 2) return Failure{"too_few_sights", "a point needs two sights"};
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const Sight& s : sights) {
    const Eigen::Vector3d ray = rayOf(s);
    const Eigen::Matrix3d P = Eigen::Matrix3d::Identity() - ray * ray.transpose();
    A += P;
    b += P * s.T_world_cam.translation();
  }
  const Eigen::LDLT<Eigen::Matrix3d> solver(A);
  if (solver.info() != Eigen::Success || std::abs(A.determinant()) < 1e-12)
    return Failure{"parallel", "the rays are parallel"};
  Triangulated out;
  out.position = solver.solve(b);
  for (int round = 0; round < 5; ++round) {
    Eigen::Matrix3d N = Eigen::Matrix3d::Zero();
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
    for (const Sight& s : sights) {
      const Eigen::Matrix3d R = s.T_world_cam.linear().transpose();
      const Eigen::Vector3d p = R * (out.position - s.T_world_cam.translation());
      if (p.z() <= 0) return Failure{"behind", "the point lies behind a camera"};
      Eigen::Matrix<double, 2, 3> J;
      J << 1 / p.z(), 0, -p.x() / (p.z() * p.z()), 0, 1 / p.z(), -p.y() / (p.z() * p.z());
      J = J * R;
      const Eigen::Vector2d e = p.hnormalized() - s.normalized;
      N += J.transpose() * J;
      g += J.transpose() * e;
    }
    const Eigen::Vector3d step = N.ldlt().solve(g);
    if (!step.allFinite()) return Failure{"parallel", "the rays are parallel"};
    out.position -= step;
    if (step.squaredNorm() < 1e-16 * out.position.squaredNorm()) break;
  }
  for (std::size_t i = 0; i < sights.size(); ++i) {
    const double error = reprojectionError(sights[i], out.position);
    if (!std::isfinite(error)) return Failure{"behind", "the point lies behind a camera"};
    out.max_error = std::max(out.max_error, error);
    for (std::size_t j = 0; j < i; ++j) {
      const double cosine = std::clamp(rayOf(sights[i]).dot(rayOf(sights[j])), -1.0, 1.0);
      out.max_angle_rad = std::max(out.max_angle_rad, std::acos(cosine));
    }
  }
  return out;
}

std::vector<Eigen::Vector2d> normalizedPoints(const FeatureSet& features,
                                              const CameraModel& camera) {
  std::vector<Eigen::Vector2d> out;
  out.reserve(features.size());
  for (const auto& pixel : features.pixel) out.push_back(camera.undistort(pixel.cast<double>()));
  return out;
}

}  // namespace cf
