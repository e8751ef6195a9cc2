// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "posterior.h"

#include <ceres/cost_function.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <array>
#include <memory>
#include <random>
#include <utility>

namespace cf {
namespace {

/// Residuals linear in some blocks.
class Linear : public ceres::CostFunction {
 public:
  explicit Linear(std::vector<Eigen::MatrixXd> A) : A_(std::move(A)) {
    set_num_residuals(static_cast<int>(A_[0].rows()));
    for (const auto& a : A_) mutable_parameter_block_sizes()->push_back(static_cast<int>(a.cols()));
  }
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    Eigen::Map<Eigen::VectorXd> r(residuals, num_residuals());
    r.setZero();
    for (std::size_t i = 0; i < A_.size(); ++i) {
      r += A_[i] * Eigen::Map<const Eigen::VectorXd>(x[i], A_[i].cols());
      if (jacobians == nullptr || jacobians[i] == nullptr) continue;
      Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
          jacobians[i], A_[i].rows(), A_[i].cols()) = A_[i];
    }
    return true;
  }

 private:
  std::vector<Eigen::MatrixXd> A_;
};

/// A chain of ten cameras, each point seen by three neighbours, against dense matrices.
TEST(DrawErrors, HaveTheCovarianceOfTheSolution) {
  constexpr int kCameras = 10, kPoints = 40, kSize = 4, kDraws = 20000;
  constexpr double kVariance = 0.3;  // of observations
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const auto matrix = [&](int rows, int columns) {
    return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return normal(random); }).eval();
  };
  std::vector<std::array<double, kSize>> cameras(kCameras);
  std::vector<std::array<double, 3>> points(kPoints);
  ceres::Problem problem;
  const int n = kSize * kCameras + 3 * kPoints;
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(n, n), noise = information;
  const auto add = [&](int camera, int point) {
    Eigen::MatrixXd row = Eigen::MatrixXd::Zero(2, n);
    const Eigen::MatrixXd A = matrix(2, kSize), B = matrix(2, 3);
    row.middleCols(kSize * camera, kSize) = A;
    if (point < 0) {
      problem.AddResidualBlock(new Linear({A}), nullptr,
                               cameras[static_cast<std::size_t>(camera)].data());
    } else {
      row.middleCols(kSize * kCameras + 3 * point, 3) = B;
      problem.AddResidualBlock(new Linear({A, B}), nullptr,
                               cameras[static_cast<std::size_t>(camera)].data(),
                               points[static_cast<std::size_t>(point)].data());
    }
    information += row.transpose() * row;
    noise += (point < 0 ? 1 : kVariance) * row.transpose() * row;
  };
  for (int p = 0; p < kPoints; ++p)
    for (int k = 0; k < 3; ++k) add((p + k) % kCameras, p);
  for (int k = 0; k < 4; ++k) add(0, -1);

  std::vector<double*> eliminated, kept;
  for (auto& p : points) eliminated.push_back(p.data());
  for (auto& c : cameras) kept.push_back(c.data());
  const auto found = drawErrors(problem, eliminated, kept, kVariance, kDraws);
  const Eigen::MatrixXd inverse = information.inverse(), dense = inverse * noise * inverse;
  ASSERT_EQ(found.size(), kept.size());
  const Eigen::MatrixXd other = found[4] * found[5].transpose() / kDraws,
                        truth_other = dense.block(kSize * 4, kSize * 5, kSize, kSize);
  for (int i = 0; i < kCameras; ++i) {
    const Eigen::MatrixXd truth = dense.block(kSize * i, kSize * i, kSize, kSize);
    const Eigen::MatrixXd& errors = found[static_cast<std::size_t>(i)];
    ASSERT_EQ(errors.rows(), kSize);
    ASSERT_EQ(errors.cols(), kDraws);
    // So that every direction counts alike: the identity.
    const Eigen::MatrixXd whitened =
        truth.llt().matrixL().solve(errors * errors.transpose() / kDraws) *
        Eigen::MatrixXd(truth.llt().matrixL()).inverse().transpose();
    EXPECT_LT((whitened - Eigen::MatrixXd::Identity(kSize, kSize)).cwiseAbs().maxCoeff(), 0.05)
        << "camera " << i;
  }
  EXPECT_LT(
      (other - truth_other).norm(),
      0.05 * std::max(truth_other.norm(), dense.block(kSize * 4, kSize * 4, kSize, kSize).norm()))
      << "they go together";
  EXPECT_EQ(drawErrors(problem, eliminated, kept, kVariance, 3)[2],
            drawErrors(problem, eliminated, kept, kVariance, 3)[2]);

  problem.SetParameterBlockConstant(kept[4]);
  EXPECT_EQ(drawErrors(problem, eliminated, kept, kVariance, 3)[4].norm(), 0) << "known";
}

TEST(DrawErrors, EmptyWhereNothingIsDetermined) {
  std::array<double, 2> x = {0, 0};
  ceres::Problem problem;
  Eigen::MatrixXd A(1, 2);
  A << 1, 0;
  problem.AddResidualBlock(new Linear({A}), nullptr, x.data());
  EXPECT_EQ(drawErrors(problem, {}, {x.data()}, 1, 10)[0].size(), 0);
}

}  // namespace
}  // namespace cf
