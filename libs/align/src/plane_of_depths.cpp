// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "plane_of_depths.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "cf/base/median.h"

namespace cf {

std::optional<Eigen::Vector3d> normalOfDepths(const std::vector<Eigen::Vector2d>& points,
                                              const std::vector<double>& depths) {
  std::vector<Eigen::Vector4d> rows;  // x, y, 1, 1/z
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (depths[i] > 0) rows.emplace_back(points[i].x(), points[i].y(), 1, 1 / depths[i]);
  }
  if (static_cast<int>(rows.size()) < 2 * kMinDepths) return std::nullopt;
  Eigen::Vector3d fit = Eigen::Vector3d::Zero();
  std::vector<double> weight(rows.size(), 1), residual(rows.size());
  for (int round = 0; round < 10; ++round) {
    Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const Eigen::Vector3d x = rows[i].head<3>();
      hessian += weight[i] * x * x.transpose();
      gradient += weight[i] * x * rows[i][3];
    }
    fit = hessian.ldlt().solve(gradient);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      residual[i] = std::abs(rows[i].head<3>().dot(fit) - rows[i][3]);
    }
    const double scale = std::max(2 * upperMedian(residual), 1e-12);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      weight[i] = 1 / (1 + std::pow(residual[i] / scale, 2));
    }
  }
  if (!(fit.z() > 0)) return std::nullopt;
  return fit.normalized();
}

}  // namespace cf
