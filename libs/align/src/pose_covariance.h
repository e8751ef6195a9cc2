// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

namespace cf {

/// Errors of camera poses, drawn at random: translation [m] and rotation vector [rad], both in the
/// world (left perturbation), a column for each draw.
using ErrorDraws = Eigen::Matrix<double, 6, Eigen::Dynamic>;

/// The errors that are left after the similarity (to first order) that fits the centres of all
/// photos best onto where they are: how photos lie to each other, without where the map lies as a
/// whole. What the centres do not determine (the roll about one line) is not taken off.
std::vector<ErrorDraws> withoutSimilarity(std::vector<ErrorDraws> errors,
                                          const std::vector<Eigen::Vector3d>& centres);

Eigen::Matrix<double, 6, 6> covarianceOf(const ErrorDraws& errors);

}  // namespace cf
