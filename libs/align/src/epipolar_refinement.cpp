// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "epipolar_refinement.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

#include "cf/base/median.h"

namespace cf {
namespace {

using Vector5d = Eigen::Matrix<double, 5, 1>;
using Matrix5d = Eigen::Matrix<double, 5, 5>;

double sampsonError(const Eigen::Matrix3d& E, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector3d line_a = E * b.homogeneous(), line_b = E.transpose() * a.homogeneous();
  const double gradient = line_a.head<2>().squaredNorm() + line_b.head<2>().squaredNorm();
  return a.homogeneous().dot(line_a) / std::sqrt(gradient + 1e-18);
}

Eigen::Isometry3d moved(const Eigen::Isometry3d& T_a_b, const Vector5d& step) {
  const Eigen::Vector3d t = T_a_b.translation();
  const Eigen::Vector3d u = t.unitOrthogonal();
  const Eigen::Vector3d w = step.tail<3>();
  Eigen::Isometry3d out = T_a_b;
  out.translation() = (t + step[0] * u + step[1] * t.cross(u)).normalized();
  if (w.norm() > 0) {
    out.linear() = T_a_b.linear() * Eigen::AngleAxisd(w.norm(), w.normalized()).toRotationMatrix();
  }
  return out;
}

/// x_a' E x_b = 0 with E = [t] R of T_a_b.
Eigen::Matrix3d essentialOf(const Eigen::Isometry3d& T_a_b) {
  Eigen::Matrix3d E;
  for (int c = 0; c < 3; ++c) E.col(c) = T_a_b.translation().cross(T_a_b.linear().col(c));
  return E;
}

}  // namespace

EpipolarPose refineEpipolar(const Eigen::Isometry3d& T_a_b, const std::vector<Eigen::Vector2d>& a,
                            const std::vector<Eigen::Vector2d>& b,
                            const std::vector<char>& inlier) {
  constexpr double kStep = 1e-6, kCauchy = 2.385;
  constexpr int kRounds = 6;
  EpipolarPose pose;
  pose.T_a_b = T_a_b;
  for (int round = 0; round <= kRounds; ++round) {
    const Eigen::Matrix3d here = essentialOf(pose.T_a_b);
    std::vector<double> errors;
    for (std::size_t i = 0; i < a.size(); ++i) {
      if (inlier[i]) errors.push_back(std::abs(sampsonError(here, a[i], b[i])));
    }
    const double sigma = std::max(1.4826 * upperMedian(std::move(errors)), 1e-9);

    Eigen::Matrix3d plus[5], minus[5];
    for (int k = 0; k < 5; ++k) {
      plus[k] = essentialOf(moved(pose.T_a_b, kStep * Vector5d::Unit(k)));
      minus[k] = essentialOf(moved(pose.T_a_b, -kStep * Vector5d::Unit(k)));
    }
    Matrix5d hessian = Matrix5d::Zero();
    Vector5d gradient = Vector5d::Zero();
    for (std::size_t i = 0; i < a.size(); ++i) {
      if (!inlier[i]) continue;
      const double e = sampsonError(here, a[i], b[i]) / sigma;
      Vector5d J;
      for (int k = 0; k < 5; ++k) {
        J[k] = (sampsonError(plus[k], a[i], b[i]) - sampsonError(minus[k], a[i], b[i])) /
               (2 * kStep * sigma);
      }
      const double weight = 1 / (1 + e * e / (kCauchy * kCauchy));
      hessian += weight * J * J.transpose();
      gradient += weight * J * e;
    }
    const auto factors = hessian.ldlt();
    pose.sigma = sigma;
    pose.covariance = factors.solve(Matrix5d::Identity());
    if (round < kRounds) pose.T_a_b = moved(pose.T_a_b, -factors.solve(gradient));
  }
  return pose;
}

}  // namespace cf
