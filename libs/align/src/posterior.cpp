// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "posterior.h"

#include <ceres/cost_function.h>
#include <ceres/crs_matrix.h>
#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <unordered_map>
#include <utility>

namespace cf {
namespace {

using SparseMatrix = Eigen::SparseMatrix<double>;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Information of the blocks that are not points: its lower triangle by pairs of blocks, first >=
/// second.
class ReducedInformation {
 public:
  /// `first_column` of every block, and one past the last.
  explicit ReducedInformation(std::vector<int> first_column)
      : first_column_(std::move(first_column)) {}

  int dimension() const { return first_column_.back(); }
  /// Of the same blocks, without any information.
  ReducedInformation empty() const { return ReducedInformation(first_column_); }

  /// Adds the information of some rows of a Jacobian that have at most one point in common. The
  /// points' columns come first, up to `points_end`.
  void add(const ceres::CRSMatrix& jacobian, int points_end, const std::vector<int>& rows) {
    std::vector<int> touched;
    for (const int row : rows)
      for (int k = jacobian.rows[at(row)]; k < jacobian.rows[at(row + 1)]; ++k)
        if (jacobian.cols[at(k)] >= points_end)
          touched.push_back(blockOf(jacobian.cols[at(k)] - points_end));
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
          const int block = blockOf(column - points_end);
          A(row, local[block] + column - points_end - first_column_[at(block)]) = value;
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
        sum(a, b) += information.block(local[a], local[b], size(a), size(b));
      }
  }

  /// Adds that of other rows.
  void add(const ReducedInformation& other) {
    for (const auto& [blocks, part] : other.sums_) sum(blocks.first, blocks.second) += part;
  }

  SparseMatrix lowerTriangle() const {
    std::vector<Eigen::Triplet<double>> entries;
    for (const auto& [blocks, sum] : sums_)
      for (int i = 0; i < sum.rows(); ++i)
        for (int j = 0; j < sum.cols(); ++j) {
          const int row = first_column_[at(blocks.first)] + i;
          const int column = first_column_[at(blocks.second)] + j;
          if (row >= column) entries.emplace_back(row, column, sum(i, j));
        }
    SparseMatrix lower(dimension(), dimension());
    lower.setFromTriplets(entries.begin(), entries.end());
    return lower;
  }

 private:
  Eigen::MatrixXd& sum(int a, int b) {
    const auto found = sums_.find({a, b});
    if (found != sums_.end()) return found->second;
    return sums_[{a, b}] = Eigen::MatrixXd::Zero(size(a), size(b));
  }
  int size(int block) const { return first_column_[at(block + 1)] - first_column_[at(block)]; }
  int blockOf(int column) const {
    return static_cast<int>(std::upper_bound(first_column_.begin(), first_column_.end(), column) -
                            first_column_.begin() - 1);
  }

  std::vector<int> first_column_;
  std::map<std::pair<int, int>, Eigen::MatrixXd> sums_;
};

struct Residuals {
  std::vector<std::vector<ceres::ResidualBlockId>> of_point;
  std::vector<ceres::ResidualBlockId> others;  ///< that see none
};

Residuals residualsOf(const ceres::Problem& problem, const std::vector<double*>& points) {
  std::unordered_map<const double*, std::size_t> index;
  for (std::size_t i = 0; i < points.size(); ++i) index[points[i]] = i;
  std::vector<ceres::ResidualBlockId> all;
  problem.GetResidualBlocks(&all);
  Residuals out;
  out.of_point.resize(points.size());
  std::vector<double*> blocks;
  for (const ceres::ResidualBlockId id : all) {
    problem.GetParameterBlocksForResidualBlock(id, &blocks);
    const auto point = std::find_if(blocks.begin(), blocks.end(),
                                    [&](const double* block) { return index.count(block) > 0; });
    if (point == blocks.end())
      out.others.push_back(id);
    else
      out.of_point[index.at(*point)].push_back(id);
  }
  return out;
}

/// The Jacobian of all points at once would be as large as the problem: so many at a time.
constexpr std::size_t kPointsAtOnce = 8192, kPointsOfTask = 512;

void addPoints(ceres::Problem& problem, const std::vector<double*>& points,
               const std::vector<std::vector<ceres::ResidualBlockId>>& of_point,
               const std::vector<double*>& moving, ReducedInformation& reduced) {
  const ReducedInformation none = reduced.empty();
  for (std::size_t begin = 0; begin < points.size(); begin += kPointsAtOnce) {
    const std::size_t end = std::min(points.size(), begin + kPointsAtOnce);
    ceres::Problem::EvaluateOptions evaluate;
    std::vector<std::vector<int>> rows;  // by point
    int row = 0;
    for (std::size_t p = begin; p < end; ++p) {
      evaluate.parameter_blocks.push_back(points[p]);
      rows.emplace_back();
      for (const ceres::ResidualBlockId id : of_point[p]) {
        evaluate.residual_blocks.push_back(id);
        const int size = problem.GetCostFunctionForResidualBlock(id)->num_residuals();
        for (int k = 0; k < size; ++k) rows.back().push_back(row++);
      }
    }
    if (row == 0) continue;
    evaluate.parameter_blocks.insert(evaluate.parameter_blocks.end(), moving.begin(), moving.end());
    ceres::CRSMatrix jacobian;
    problem.Evaluate(evaluate, nullptr, nullptr, nullptr, &jacobian);
    // Summed by tasks of fixed size and then in their order, whatever the number of threads.
    std::vector<ReducedInformation> parts((rows.size() + kPointsOfTask - 1) / kPointsOfTask, none);
    tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t t) {
      const std::size_t last = std::min(rows.size(), (t + 1) * kPointsOfTask);
      for (std::size_t p = t * kPointsOfTask; p < last; ++p)
        if (!rows[p].empty()) parts[t].add(jacobian, 3 * static_cast<int>(end - begin), rows[p]);
    });
    for (const ReducedInformation& part : parts) reduced.add(part);
  }
}

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
  std::vector<int> first_column = {0};
  std::vector<double*> moving;
  std::vector<std::size_t> free;  // their places in `blocks`
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const int size = problem.ParameterBlockTangentSize(blocks[i]);
    if (problem.IsParameterBlockConstant(blocks[i]) || size == 0) {
      errors[i] = Eigen::MatrixXd::Zero(size, draws);
      continue;
    }
    moving.push_back(blocks[i]);
    free.push_back(i);
    first_column.push_back(first_column.back() + size);
  }
  if (free.empty()) return errors;
  const Residuals seen = residualsOf(problem, points);
  ceres::Problem::EvaluateOptions evaluate;
  evaluate.parameter_blocks = moving;
  evaluate.residual_blocks = seen.others;
  ReducedInformation reduced(first_column);
  ceres::CRSMatrix jacobian;
  problem.Evaluate(evaluate, nullptr, nullptr, nullptr, &jacobian);
  std::vector<Eigen::Triplet<double>> others;
  const int other_rows = jacobian.num_rows;
  for (int row = 0; row < other_rows; ++row) {
    reduced.add(jacobian, 0, {row});
    for (int k = jacobian.rows[at(row)]; k < jacobian.rows[at(row + 1)]; ++k)
      others.emplace_back(jacobian.cols[at(k)], row, jacobian.values[at(k)]);
  }
  addPoints(problem, points, seen.of_point, moving, reduced);

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
    errors[free[i]] =
        drawn_errors.middleRows(first_column[i], first_column[i + 1] - first_column[i]);
  return errors;
}

}  // namespace cf
