// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ceres/problem.h>

#include <Eigen/Core>
#include <vector>

namespace cf {

/// Marginal covariance of each of `blocks` at the values that they have, in its tangent space, from
/// the Gauss-Newton information of all residuals, losses included. `points` are marginalised first:
/// blocks of three coordinates, no residual with two of them. What is constant counts as known.
/// Sparse throughout: the inverse is computed on the pattern of the factor only (Takahashi, Fagan
/// and Chin 1973). Empty where the information is singular.
std::vector<Eigen::MatrixXd> marginalCovariances(ceres::Problem& problem,
                                                 const std::vector<double*>& points,
                                                 const std::vector<double*>& blocks);

}  // namespace cf
