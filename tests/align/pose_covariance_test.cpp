// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "pose_covariance.h"

#include <gtest/gtest.h>

#include <random>

#include "cf/geometry/similarity.h"

namespace cf {
namespace {

std::vector<Eigen::Vector3d> grid() {
  std::vector<Eigen::Vector3d> centres;
  for (int i = 0; i < 12; ++i) centres.emplace_back(300 + 20 * (i % 4), 30 * (i / 4), 90 + i % 3);
  return centres;
}

/// Small errors that a turn, a shift and a scale make vanish; and what an alignment leaves of
/// others, to first order.
TEST(WithoutSimilarity, LeavesWhatAnAlignmentLeaves) {
  const std::vector<Eigen::Vector3d> centres = grid();
  std::mt19937 random(1);
  std::normal_distribution<double> normal(0, 1e-5);
  const Eigen::Vector3d turn(1e-5, -2e-5, 3e-5), shift(0.1, 0.2, -0.3);
  std::vector<ErrorDraws> errors;
  for (const Eigen::Vector3d& c : centres) {
    ErrorDraws e(6, 2);
    e.col(0) << shift + turn.cross(c) + 1e-5 * c, turn;
    e.col(1) = ErrorDraws::NullaryExpr(6, 1, [&] { return normal(random); });
    errors.push_back(e);
  }
  std::vector<Eigen::Vector3d> estimates;
  for (std::size_t i = 0; i < centres.size(); ++i)
    estimates.push_back(centres[i] + errors[i].col(1).head<3>());
  const auto S = alignPoints(centres, estimates, AlignmentModel::kSim3);
  ASSERT_TRUE(S);
  const Eigen::AngleAxisd back(S->rotation);
  const std::vector<ErrorDraws> left = withoutSimilarity(errors, centres);
  for (std::size_t i = 0; i < centres.size(); ++i) {
    EXPECT_LT(left[i].col(0).norm(), 1e-9) << i;
    Eigen::Matrix<double, 6, 1> aligned;
    aligned << *S * estimates[i] - centres[i],
        errors[i].col(1).tail<3>() + back.angle() * back.axis();
    EXPECT_LT((left[i].col(1) - aligned).norm(), 1e-8) << i;
  }
}

/// About the line of a straight flight nothing is taken off.
TEST(WithoutSimilarity, KeepsTheRollAboutALine) {
  std::vector<Eigen::Vector3d> centres;
  std::vector<ErrorDraws> errors;
  for (int i = 0; i < 6; ++i) {
    centres.emplace_back(20 * i, 0, 90);
    ErrorDraws e = ErrorDraws::Zero(6, 1);
    e(3, 0) = 0.01;
    errors.push_back(e);
  }
  for (const ErrorDraws& e : withoutSimilarity(errors, centres)) {
    EXPECT_NEAR(e(3, 0), 0.01, 1e-9);
    EXPECT_LT(e.topRows<3>().norm(), 1e-9);
  }
}

TEST(CovarianceOf, IsTheMeanOfSquares) {
  ErrorDraws e = ErrorDraws::Zero(6, 2);
  e.col(0) << 1, 2, 0, 0, 0, 0;
  e.col(1) << 1, -2, 0, 0, 0, 3;
  const Eigen::Matrix<double, 6, 6> c = covarianceOf(e);
  EXPECT_DOUBLE_EQ(c(0, 0), 1);
  EXPECT_DOUBLE_EQ(c(1, 1), 4);
  EXPECT_DOUBLE_EQ(c(0, 1), 0);
  EXPECT_DOUBLE_EQ(c(1, 5), -3);
}

}  // namespace
}  // namespace cf
