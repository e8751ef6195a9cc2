// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "photo_pose.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "cf/geometry/triangulation.h"

namespace cf {
namespace {

using Jacobian = Eigen::Matrix<double, 2, 6>;

/// Of the normalized projection by a rotation and a shift of the camera frame.
Jacobian jacobian(const Eigen::Vector3d& p) {
  Eigen::Matrix<double, 2, 3> project;
  project << 1 / p.z(), 0, -p.x() / (p.z() * p.z()), 0, 1 / p.z(), -p.y() / (p.z() * p.z());
  Eigen::Matrix<double, 3, 6> move;
  move << 0, p.z(), -p.y(), 1, 0, 0,  //
      -p.z(), 0, p.x(), 0, 1, 0,      //
      p.y(), -p.x(), 0, 0, 0, 1;
  return project * move;
}

}  // namespace

double strayAtCorners(const Eigen::Isometry3d& T_local_cam, const std::vector<LandmarkSight>& seen,
                      const Eigen::Vector2d& corner, double sigma) {
  Eigen::Matrix<double, 6, 6> N = Eigen::Matrix<double, 6, 6>::Zero();
  const Eigen::Isometry3d T_cam_local = T_local_cam.inverse();
  double depth = 0;
  for (const LandmarkSight& s : seen) {
    const Eigen::Vector3d p = T_cam_local * s.p_local;
    const Jacobian J = jacobian(p);
    N += J.transpose() * J;
    depth += p.z() / static_cast<double>(seen.size());
  }
  // Shifts in units of the depth: the numbers of N become alike.
  Eigen::Matrix<double, 6, 1> unit;
  unit << 1, 1, 1, depth, depth, depth;
  const Eigen::Matrix<double, 6, 6> scaled = unit.asDiagonal() * N * unit.asDiagonal();
  const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> solver(scaled);
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  if (!(depth > 0) || solver.info() != Eigen::Success || !solver.isPositive() ||
      solver.rcond() < 1e-12)
    return kInfinite;
  double worst = 0;
  for (const double x : {-1.0, 1.0})
    for (const double y : {-1.0, 1.0}) {
      const Eigen::Vector3d p(depth * x * corner.x(), depth * y * corner.y(), depth);
      const Jacobian J = jacobian(p) * unit.asDiagonal();
      const Eigen::Matrix2d covariance = J * solver.solve(J.transpose());
      worst = std::max(worst, sigma * std::sqrt(covariance.eigenvalues().real().maxCoeff()));
    }
  return std::isfinite(worst) ? worst : kInfinite;
}

Result<Eigen::Isometry3d> poseByScaledTwoView(const Eigen::Isometry3d& T_local_a,
                                              const Eigen::Isometry3d& T_a_cam_up_to_scale,
                                              const std::vector<LandmarkSight>& seen,
                                              double threshold, int least_landmarks) {
  const Eigen::Isometry3d T_a_local = T_local_a.inverse();
  const Eigen::Matrix3d R_cam_a = T_a_cam_up_to_scale.linear().transpose();
  const Eigen::Vector3d along = R_cam_a * T_a_cam_up_to_scale.translation().normalized();
  // The photo sees a landmark at p - s along, for the length s: its cross product with the ray that
  // it is seen on is 0, which is linear in s.
  struct Vote {
    double length = 0, weight = 0;
  };
  std::vector<Vote> votes;
  for (const LandmarkSight& s : seen) {
    const Eigen::Vector3d p = R_cam_a * (T_a_local * s.p_local);
    const Eigen::Vector3d ray = s.normalized.homogeneous();
    const Eigen::Vector3d a = p.cross(ray), b = along.cross(ray);
    if (b.squaredNorm() > 0)  // else it lies on the baseline and tells nothing of its length
      votes.push_back({a.dot(b) / b.squaredNorm(), b.squaredNorm() / (p.z() * p.z())});
    else
      votes.push_back({});
  }
  const auto poseAt = [&](double length) {
    Eigen::Isometry3d T_a_cam = T_a_cam_up_to_scale;
    T_a_cam.translation() = length * T_a_cam_up_to_scale.translation().normalized();
    return Eigen::Isometry3d(T_local_a * T_a_cam);
  };
  const auto agree = [&](const Eigen::Isometry3d& T_local_cam, std::size_t i) {
    return reprojectionError({T_local_cam, seen[i].normalized}, seen[i].p_local) < threshold;
  };
  const auto count = [&](double length) {
    const Eigen::Isometry3d T = poseAt(length);
    int inliers = 0;
    for (std::size_t i = 0; i < seen.size(); ++i) inliers += agree(T, i);
    return inliers;
  };
  double best_length = 0;
  int most = 0;
  const std::size_t step = std::max<std::size_t>(1, votes.size() / 100);
  for (std::size_t i = 0; i < votes.size(); i += step) {
    if (!(votes[i].length > 0)) continue;
    const int inliers = count(votes[i].length);
    if (inliers <= most) continue;
    most = inliers;
    best_length = votes[i].length;
  }
  if (most < least_landmarks || 2 * most < static_cast<int>(seen.size()))
    return Failure{"no_scale", std::to_string(most) + " of " + std::to_string(seen.size()) +
                                   " landmarks agree on the length of the baseline"};
  const Eigen::Isometry3d rough = poseAt(best_length);
  double sum = 0, weight = 0;
  for (std::size_t i = 0; i < votes.size(); ++i)
    if (agree(rough, i)) {
      sum += votes[i].weight * votes[i].length;
      weight += votes[i].weight;
    }
  return poseAt(sum / weight);
}

}  // namespace cf
