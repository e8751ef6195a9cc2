// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "inverse_depth_solver.h"

#include <Eigen/Dense>
#include <cmath>
#include <optional>
#include <utility>

namespace cf {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;  ///< rotation in the camera's frame, translation
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Matrix26d = Eigen::Matrix<double, 2, 6>;

constexpr int kMostIterations = 12;
constexpr double kConverged = 1e-5;  ///< relative decrease of the cost
constexpr double kFirstDamping = 1e-4, kMostDamping = 1e6;

Eigen::Matrix3d crossMatrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

AdjustedPose moved(const AdjustedPose& pose, const Vector6d& step) {
  AdjustedPose out = pose;
  const double angle = step.head<3>().norm();
  if (angle > 0) {
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle, step.head<3>() / angle));
    out.R = (Eigen::Quaterniond(pose.R) * turn).normalized().toRotationMatrix();
  }
  out.t += step.tail<3>();
  if (pose.length_held) out.t *= pose.t.norm() / out.t.norm();
  return out;
}

/// Equation (2), projection of an anchored inverse depth into another photo, in that camera's
/// frame, times the inverse depth: with it going to zero the point goes to infinity smoothly.
Eigen::Vector3d inCamera(const AdjustedPose& anchor, const AdjustedPose& target,
                         const Eigen::Vector3d& ray, double inverse_depth) {
  return target.R.transpose() * (anchor.R * ray + inverse_depth * (anchor.t - target.t));
}

/// Minimises equation (1), the sum over the residuals of equation (3).
class Solver {
 public:
  Solver(std::vector<AdjustedPose>& poses, std::vector<AdjustedPoint>& points, double huber)
      : poses_(poses), points_(points), huber_(huber) {
    for (const AdjustedPose& pose : poses_) {
      column_.push_back(pose.held ? -1 : unknowns_);
      if (!pose.held) unknowns_ += 6;
    }
    for (const AdjustedPoint& point : points_) inverse_depth_.push_back(point.inverse_depth);
    eliminated_.resize(points_.size());
  }

  bool solve() {
    std::optional<double> cost = costOf(poses_, inverse_depth_);
    if (!cost) return false;
    double damping = kFirstDamping;
    for (int iteration = 0; iteration < kMostIterations; ++iteration) {
      linearise();
      double gain = tryStep(damping, *cost);
      while (gain <= 0 && damping < kMostDamping) {
        damping *= 8;
        gain = tryStep(damping, *cost);
      }
      if (gain <= 0) break;
      damping *= 0.1;
      *cost *= 1 - gain;
      if (gain < kConverged) break;
    }
    for (std::size_t k = 0; k < points_.size(); ++k) points_[k].inverse_depth = inverse_depth_[k];
    return true;
  }

 private:
  /// A point's part of the normal equations. With `rows`, one for each pose that moves it.
  struct Eliminated {
    double curvature = 0, gradient = 0;
    std::vector<std::pair<int, Vector6d>> rows;  ///< by the pose's column
  };

  /// None if a point lies behind a camera that sees it.
  std::optional<double> costOf(const std::vector<AdjustedPose>& poses,
                               const std::vector<double>& inverse_depth) const {
    double sum = 0;
    for (std::size_t k = 0; k < points_.size(); ++k) {
      const AdjustedPoint& point = points_[k];
      const Eigen::Vector3d ray = point.anchor_normalized.homogeneous();
      for (const auto& sighting : point.sightings) {
        const Eigen::Vector3d p =
            inCamera(at(poses, point.anchor), at(poses, sighting.pose), ray, inverse_depth[k]);
        if (p.z() < 1e-6) return std::nullopt;
        const double e = (p.hnormalized() - sighting.normalized).norm();
        sum += e < huber_ ? e * e : huber_ * (2 * e - huber_);
      }
    }
    return sum;
  }

  void linearise() {
    curvature_.setZero(unknowns_, unknowns_);
    gradient_.setZero(unknowns_);
    for (std::size_t k = 0; k < points_.size(); ++k) linearise(points_[k], k);
  }

  void linearise(const AdjustedPoint& point, std::size_t k) {
    Eliminated& own = eliminated_[k];
    own = {};
    const AdjustedPose& anchor = at(poses_, point.anchor);
    const int anchor_column = column_[static_cast<std::size_t>(point.anchor)];
    const Eigen::Vector3d ray = point.anchor_normalized.homogeneous();
    const double inverse_depth = inverse_depth_[k];
    const Eigen::Matrix3d turned = -anchor.R * crossMatrix(ray);
    Vector6d anchor_row = Vector6d::Zero();
    for (const auto& sighting : point.sightings) {
      const AdjustedPose& target = at(poses_, sighting.pose);
      const Eigen::Vector3d p = inCamera(anchor, target, ray, inverse_depth);
      const Eigen::Vector2d error = p.hnormalized() - sighting.normalized;
      const double size = error.norm(), weight = size < huber_ ? 1 : huber_ / size;
      Eigen::Matrix<double, 2, 3> by_camera;
      by_camera << 1 / p.z(), 0, -p.x() / (p.z() * p.z()), 0, 1 / p.z(), -p.y() / (p.z() * p.z());
      const Eigen::Matrix<double, 2, 3> by_local = by_camera * target.R.transpose();
      const Eigen::Vector2d by_depth = by_local * (anchor.t - target.t);
      own.curvature += weight * by_depth.squaredNorm();
      own.gradient += weight * by_depth.dot(error);
      Matrix26d by_anchor, by_target;
      if (anchor_column >= 0) {
        by_anchor << by_local * turned, translationJacobian(inverse_depth * by_local, anchor);
        anchor_row += weight * by_anchor.transpose() * by_depth;
        addBlock(anchor_column, weight, by_anchor, error);
      }
      const int column = column_[static_cast<std::size_t>(sighting.pose)];
      if (column < 0) continue;
      by_target << by_camera * crossMatrix(p),
          translationJacobian(-inverse_depth * by_local, target);
      own.rows.emplace_back(column, weight * by_target.transpose() * by_depth);
      addBlock(column, weight, by_target, error);
      if (anchor_column < 0) continue;
      const Matrix6d both = weight * by_target.transpose() * by_anchor;
      curvature_.block<6, 6>(column, anchor_column) += both;
      curvature_.block<6, 6>(anchor_column, column) += both.transpose();
    }
    if (anchor_column >= 0) own.rows.emplace_back(anchor_column, anchor_row);
  }

  void addBlock(int column, double weight, const Matrix26d& J, const Eigen::Vector2d& error) {
    curvature_.block<6, 6>(column, column) += weight * J.transpose() * J;
    gradient_.segment<6>(column) += weight * J.transpose() * error;
  }

  /// A translation of held length moves at right angles to itself.
  static Eigen::Matrix<double, 2, 3> translationJacobian(const Eigen::Matrix<double, 2, 3>& J,
                                                         const AdjustedPose& pose) {
    if (!pose.length_held) return J;
    const Eigen::Vector3d along = pose.t.normalized();
    return J - J * along * along.transpose();
  }

  /// Takes the step if it lowers the cost; by what share it does, or 0.
  double tryStep(double damping, double cost) {
    Eigen::MatrixXd S = curvature_;
    const double least = 1e-9 * curvature_.diagonal().maxCoeff();
    for (int i = 0; i < unknowns_; ++i) S(i, i) += damping * S(i, i) + least;
    Eigen::VectorXd g = gradient_;
    for (const Eliminated& point : eliminated_) {
      const double inverse = 1 / (point.curvature * (1 + damping));
      for (const auto& [column, row] : point.rows) {
        g.segment<6>(column) -= point.gradient * inverse * row;
        const Vector6d scaled = inverse * row;
        for (const auto& [other, other_row] : point.rows)
          S.block<6, 6>(column, other) -= scaled * other_row.transpose();
      }
    }
    const Eigen::VectorXd step = unknowns_ > 0 ? Eigen::VectorXd(-S.ldlt().solve(g)) : -g;
    if (!step.allFinite()) return 0;
    std::vector<AdjustedPose> poses = poses_;
    for (std::size_t i = 0; i < poses.size(); ++i)
      if (column_[i] >= 0) poses[i] = moved(poses[i], step.segment<6>(column_[i]));
    std::vector<double> inverse_depth = inverse_depth_;
    for (std::size_t k = 0; k < points_.size(); ++k) {
      double g_point = eliminated_[k].gradient;
      for (const auto& [column, row] : eliminated_[k].rows)
        g_point += row.dot(step.segment<6>(column));
      inverse_depth[k] -= g_point / (eliminated_[k].curvature * (1 + damping));
    }
    const std::optional<double> next = costOf(poses, inverse_depth);
    if (!next || !(*next < cost)) return 0;
    poses_ = std::move(poses);
    inverse_depth_ = std::move(inverse_depth);
    return 1 - *next / cost;
  }

  static const AdjustedPose& at(const std::vector<AdjustedPose>& poses, int i) {
    return poses[static_cast<std::size_t>(i)];
  }

  std::vector<AdjustedPose>& poses_;
  std::vector<AdjustedPoint>& points_;
  const double huber_;
  int unknowns_ = 0;
  std::vector<int> column_;  ///< of each pose's first unknown; -1: held
  std::vector<double> inverse_depth_;
  Eigen::MatrixXd curvature_;  ///< of the poses
  Eigen::VectorXd gradient_;
  std::vector<Eliminated> eliminated_;
};

}  // namespace

bool solveInverseDepths(std::vector<AdjustedPose>& poses, std::vector<AdjustedPoint>& points,
                        double huber) {
  return Solver(poses, points, huber).solve();
}

}  // namespace cf
