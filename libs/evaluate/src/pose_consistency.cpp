// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "pose_consistency.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <map>

#include "statistics.h"

namespace cf {
namespace {

constexpr double kDegrees = 180 / 3.14159265358979323846;

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

/// Translation [m] and rotation vector [rad], and their covariance.
struct NormalError {
  Vector6d error;
  Matrix6d covariance;
};

Matrix6d turned(const Matrix6d& covariance, const Eigen::Matrix3d& R) {
  Matrix6d turn = Matrix6d::Zero();
  turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = R;
  return turn * covariance * turn.transpose();
}

Vector6d errorOf(const Eigen::Isometry3d& estimate, const Eigen::Isometry3d& reference) {
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(estimate.linear() * reference.linear().transpose()));
  Vector6d error;
  error << estimate.translation() - reference.translation(), turn.angle() * turn.axis();
  return error;
}

/// Mean over the photos. Photos of one map share their errors (its place; the lens, whose error
/// bends it as a whole), so all of them say no more about the covariances than a few would: the
/// bounds are those of one pose for each independent map.
Json neesOf(const std::vector<NormalError>& errors, std::size_t maps) {
  if (errors.empty()) return nullptr;
  const auto n = static_cast<double>(errors.size());
  double both = 0, translation = 0, rotation = 0, within = 0;
  Vector6d squares = Vector6d::Zero(), variances = Vector6d::Zero();
  const double limit = chiSquareQuantile(0.95, 6);
  for (const NormalError& e : errors) {
    const double nees = e.error.dot(e.covariance.ldlt().solve(e.error));
    both += nees / n;
    translation +=
        e.error.head<3>().dot(e.covariance.topLeftCorner<3, 3>().ldlt().solve(e.error.head<3>())) /
        n;
    rotation += e.error.tail<3>().dot(
                    e.covariance.bottomRightCorner<3, 3>().ldlt().solve(e.error.tail<3>())) /
                n;
    within += nees < limit ? 1 / n : 0;
    squares += e.error.cwiseAbs2() / n;
    variances += e.covariance.diagonal() / n;
  }
  const auto freedom = 6 * static_cast<double>(maps);
  const double low = chiSquareQuantile(0.025, freedom) / static_cast<double>(maps),
               high = chiSquareQuantile(0.975, freedom) / static_cast<double>(maps);
  return {{"photos", errors.size()},
          {"nees", finite(both)},
          {"expected", 6},
          {"chi2_95", {low, high}},
          {"inside", both >= low && both <= high},
          {"nees_translation", finite(translation)},
          {"nees_rotation", finite(rotation)},
          {"photos_within_chi2_95", within},
          {"error_m", std::sqrt(squares.head<3>().sum())},
          {"sigma_m", std::sqrt(variances.head<3>().sum())},
          {"error_deg", kDegrees * std::sqrt(squares.tail<3>().sum())},
          {"sigma_deg", kDegrees * std::sqrt(variances.tail<3>().sum())}};
}

}  // namespace

std::optional<PoseCovariance> turned(const std::optional<PoseCovariance>& covariance,
                                     const Eigen::Matrix3d& R) {
  if (!covariance) return std::nullopt;
  return PoseCovariance{turned(covariance->in_world, R), turned(covariance->in_map, R)};
}

Json worldConsistency(const std::vector<PosePair>& pairs) {
  std::vector<NormalError> errors;
  for (const PosePair& pair : pairs)
    if (pair.covariance)
      errors.push_back({errorOf(pair.estimate, pair.reference), pair.covariance->in_world});
  return neesOf(errors, 1);
}

Json mapConsistency(const std::vector<PosePair>& pairs) {
  std::map<int, std::vector<const PosePair*>> components;
  for (const PosePair& pair : pairs)
    if (pair.covariance) components[pair.component].push_back(&pair);
  std::vector<NormalError> errors;
  std::size_t maps = 0;
  for (const auto& [component, of_component] : components) {
    std::vector<Eigen::Vector3d> reference, estimate;
    for (const PosePair* pair : of_component) {
      reference.push_back(pair->reference.translation());
      estimate.push_back(pair->estimate.translation());
    }
    const auto S = alignPoints(reference, estimate, AlignmentModel::kSim3);
    if (!S) continue;
    ++maps;
    for (const PosePair* pair : of_component) {
      Matrix6d covariance = turned(pair->covariance->in_map, S->rotation);
      covariance.topRows<3>() *= S->scale;
      covariance.leftCols<3>() *= S->scale;
      errors.push_back({errorOf(S->carry(pair->estimate), pair->reference), covariance});
    }
  }
  return neesOf(errors, maps);
}

}  // namespace cf
