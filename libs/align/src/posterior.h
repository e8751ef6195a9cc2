// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ceres/problem.h>

#include <Eigen/Core>
#include <vector>

namespace cf {

/// Errors that a least-squares solution may have, drawn at random: for each of `blocks` a matrix
/// with a column for each draw, in the block's tangent space at the values that it has.
/// An error of the observations, the residuals that see one of `points`, moves the solution by what
/// their weights let it; their variance is `observation_variance` (at most 1) of what the weights
/// say, that of all other residuals what theirs say. So with S the information of all after the
/// points (losses included) and H that of the other residuals, the draws have the covariance
///   v S^-1 + (1 - v) S^-1 H S^-1.
/// `points` are blocks of three coordinates, no residual sees two of them. What is constant is
/// known: zeros. Empty where the information is singular. The same draws every time.
std::vector<Eigen::MatrixXd> drawErrors(ceres::Problem& problem, const std::vector<double*>& points,
                                        const std::vector<double*>& blocks,
                                        double observation_variance, int draws);

}  // namespace cf
