// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "posterior.h"

#include <ceres/crs_matrix.h>

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <utility>

namespace cf {
namespace {

using SparseMatrix = Eigen::SparseMatrix<double>;

/// Information of the blocks after the points: its lower triangle by pairs of blocks, first >=
/// second.
class ReducedInformation {
 public:
  /// `first_column` of every block in the Jacobian, and one past the last.
  explicit ReducedInformation(std::vector<int> first_column)
      : first_column_(std::move(first_column)) {}

  int dimension() const { return first_column_.back() - first_column_.front(); }

  /// Adds the information of some rows of the Jacobian that have at most one point in common.
  void add(const ceres::CRSMatrix& jacobian, const std::vector<int>& rows) {
    const int points_end = first_column_.front();
    std::vector<int> touched;
    for (const int row : rows)
      for (int k = jacobian.rows[at(row)]; k < jacobian.rows[at(row + 1)]; ++k)
        if (jacobian.cols[at(k)] >= points_end) touched.push_back(blockOf(jacobian.cols[at(k)]));
    std::sort(touched.begin(), touched.end());
    touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
    std::map<int, int> local;  // first column of a block here
    int width = 0;
    for (const int block : touched) {
      local[block] = width;
      width += size(block);
    }
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(static_cast<long>(rows.size()), width);
    Eigen::MatrixXd P = Eigen::MatrixXd::Zero(static_cast<long>(rows.size()), 3);
    bool has_point = false;
    for (std::size_t i = 0; i < rows.size(); ++i)
      for (int k = jacobian.rows[at(rows[i])]; k < jacobian.rows[at(rows[i] + 1)]; ++k) {
        const int column = jacobian.cols[at(k)];
        const double value = jacobian.values[at(k)];
        const long row = static_cast<long>(i);
        if (column < points_end) {
          P(row, column % 3) = value;
          has_point = true;
        } else {
          const int block = blockOf(column);
          A(row, local[block] + column - first_column_[at(block)]) = value;
        }
      }
    Eigen::MatrixXd information = A.transpose() * A;
    if (has_point) {
      const Eigen::MatrixXd W = A.transpose() * P;
      const Eigen::Matrix3d H = P.transpose() * P;
      information -= W * H.ldlt().solve(W.transpose());
    }
    for (const int a : touched)
      for (const int b : touched) {
        if (b > a) break;
        auto [sum, is_new] = sums_.try_emplace({a, b}, Eigen::MatrixXd::Zero(size(a), size(b)));
        sum->second += information.block(local[a], local[b], size(a), size(b));
      }
  }

  SparseMatrix lowerTriangle() const {
    std::vector<Eigen::Triplet<double>> entries;
    for (const auto& [blocks, sum] : sums_)
      for (int i = 0; i < sum.rows(); ++i)
        for (int j = 0; j < sum.cols(); ++j) {
          const int row = first_column_[at(blocks.first)] - first_column_.front() + i;
          const int column = first_column_[at(blocks.second)] - first_column_.front() + j;
          if (row >= column) entries.emplace_back(row, column, sum(i, j));
        }
    SparseMatrix lower(dimension(), dimension());
    lower.setFromTriplets(entries.begin(), entries.end());
    return lower;
  }

 private:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  int size(int block) const { return first_column_[at(block + 1)] - first_column_[at(block)]; }
  int blockOf(int column) const {
    return static_cast<int>(std::upper_bound(first_column_.begin(), first_column_.end(), column) -
                            first_column_.begin() - 1);
  }

  std::vector<int> first_column_;
  std::map<std::pair<int, int>, Eigen::MatrixXd> sums_;
};

/// Standard normal numbers.
Eigen::MatrixXd drawn(Eigen::Index rows, Eigen::Index columns, std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return normal(random); });
}

}  // namespace

std::vector<Eigen::MatrixXd> drawErrors(ceres::Problem& problem, const std::vector<double*>& points,
                                        const std::vector<double*>& blocks,
                                        double observation_variance, int draws) {
  std::vector<Eigen::MatrixXd> errors(blocks.size());
  ceres::Problem::EvaluateOptions evaluate;
  evaluate.parameter_blocks = points;
  std::vector<int> first_column = {3 * static_cast<int>(points.size())};
  std::vector<std::size_t> free;  // of `blocks`, those that move
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const int size = problem.ParameterBlockTangentSize(blocks[i]);
    if (problem.IsParameterBlockConstant(blocks[i]) || size == 0) {
      errors[i] = Eigen::MatrixXd::Zero(size, draws);
      continue;
    }
    evaluate.parameter_blocks.push_back(blocks[i]);
    free.push_back(i);
    first_column.push_back(first_column.back() + size);
  }
  if (free.empty()) return errors;
  ceres::CRSMatrix jacobian;
  problem.Evaluate(evaluate, nullptr, nullptr, nullptr, &jacobian);

  const int points_end = first_column.front();
  std::vector<std::vector<int>> rows(points.size());
  std::vector<Eigen::Triplet<double>> others;
  int other_rows = 0;
  ReducedInformation reduced(first_column);
  for (int row = 0; row < jacobian.num_rows; ++row) {
    const int begin = jacobian.rows[static_cast<std::size_t>(row)],
              end = jacobian.rows[static_cast<std::size_t>(row) + 1];
    int point = -1;
    for (int k = begin; k < end; ++k)
      if (jacobian.cols[static_cast<std::size_t>(k)] < points_end)
        point = jacobian.cols[static_cast<std::size_t>(k)] / 3;
    if (point >= 0) {
      rows[static_cast<std::size_t>(point)].push_back(row);
      continue;
    }
    reduced.add(jacobian, {row});
    for (int k = begin; k < end; ++k)
      others.emplace_back(jacobian.cols[static_cast<std::size_t>(k)] - points_end, other_rows,
                          jacobian.values[static_cast<std::size_t>(k)]);
    ++other_rows;
  }
  for (const std::vector<int>& of_point : rows)
    if (!of_point.empty()) reduced.add(jacobian, of_point);

  const Eigen::SimplicialLDLT<SparseMatrix> factors(reduced.lowerTriangle());
  if (factors.info() != Eigen::Success || factors.vectorD().minCoeff() <= 0)
    return std::vector<Eigen::MatrixXd>(blocks.size());
  std::mt19937 random(1);
  // With S = L D L', L'^-1 D^-1/2 of standard normal numbers has the covariance S^-1.
  Eigen::MatrixXd drawn_errors = factors.vectorD().cwiseSqrt().cwiseInverse().asDiagonal() *
                                 drawn(reduced.dimension(), draws, random);
  factors.matrixU().solveInPlace(drawn_errors);
  drawn_errors = std::sqrt(observation_variance) * (factors.permutationPinv() * drawn_errors);
  SparseMatrix by_other(reduced.dimension(), other_rows);
  by_other.setFromTriplets(others.begin(), others.end());
  const Eigen::MatrixXd gradients = by_other * drawn(other_rows, draws, random);
  drawn_errors += std::sqrt(1 - observation_variance) * factors.solve(gradients);
  for (std::size_t i = 0; i < free.size(); ++i)
    errors[free[i]] = drawn_errors.middleRows(first_column[i] - points_end,
                                              first_column[i + 1] - first_column[i]);
  return errors;
}

}  // namespace cf
