// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "pose_covariance.h"

#include <Eigen/QR>

namespace cf {
namespace {

using Similarity = Eigen::Matrix<double, 6, 7>;  ///< by translation, rotation, log of scale

Similarity motionOf(const Eigen::Vector3d& arm) {
  Similarity motion = Similarity::Zero();
  motion.topLeftCorner<3, 3>().setIdentity();
  motion.block<3, 3>(0, 3) << 0, arm.z(), -arm.y(), -arm.z(), 0, arm.x(), arm.y(), -arm.x(), 0;
  motion.block<3, 1>(0, 6) = arm;
  motion.block<3, 3>(3, 3).setIdentity();
  return motion;
}

}  // namespace

std::vector<ErrorDraws> withoutSimilarity(std::vector<ErrorDraws> errors,
                                          const std::vector<Eigen::Vector3d>& centres) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& c : centres) middle += c / static_cast<double>(centres.size());
  Eigen::Matrix<double, 7, 7> normal = Eigen::Matrix<double, 7, 7>::Zero();
  Eigen::Matrix<double, 7, Eigen::Dynamic> moments;
  std::vector<Similarity> motions;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    motions.push_back(motionOf(centres[i] - middle));
    const auto centre = motions.back().topRows<3>();
    normal += centre.transpose() * centre;
    const Eigen::Matrix<double, 7, Eigen::Dynamic> moment =
        centre.transpose() * errors[i].topRows<3>();
    if (i == 0)
      moments = moment;
    else
      moments += moment;
  }
  // So that turns and lengths compare: as far out as the centres are spread.
  Eigen::Matrix<double, 7, 1> unit = Eigen::Matrix<double, 7, 1>::Ones();
  unit.tail<4>().setConstant(1 / std::sqrt(std::max(1e-12, normal(6, 6) / normal(0, 0))));
  Eigen::CompleteOrthogonalDecomposition<Eigen::Matrix<double, 7, 7>> solver;
  solver.setThreshold(1e-6);
  solver.compute(unit.asDiagonal() * normal * unit.asDiagonal());
  const Eigen::Matrix<double, 7, Eigen::Dynamic> fit =
      unit.asDiagonal() * solver.solve(unit.asDiagonal() * moments);
  for (std::size_t i = 0; i < errors.size(); ++i) errors[i] -= motions[i] * fit;
  return errors;
}

Eigen::Matrix<double, 6, 6> covarianceOf(const ErrorDraws& errors) {
  return errors * errors.transpose() / static_cast<double>(errors.cols());
}

}  // namespace cf
