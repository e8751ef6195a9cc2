// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>

#include "segment.h"

namespace cf {

ChainCovariance marginals(const ChainInformation& info) {
  using Vector6d = Eigen::Matrix<double, 6, 1>;
  const std::size_t n = info.diagonal.size();
  const auto inverse = [](const Matrix6d& m) -> Matrix6d {
    return m.ldlt().solve(Matrix6d::Identity());
  };
  // Schur complements of everything before (forward) and after (backward) each block.
  std::vector<Matrix6d> forward(n), backward(n), forward_inverse(n);
  std::vector<Vector6d> reduced(n), solution(n);  // of A x = border
  for (std::size_t i = 0; i < n; ++i) {
    forward[i] = info.diagonal[i];
    reduced[i] = info.border[i];
    if (i > 0) {
      const Matrix6d gain = info.upper[i - 1].transpose() * forward_inverse[i - 1];
      forward[i] -= gain * info.upper[i - 1];
      reduced[i] -= gain * reduced[i - 1];
    }
    forward_inverse[i] = inverse(forward[i]);
  }
  for (std::size_t i = n; i-- > 0;) {
    backward[i] = info.diagonal[i];
    Vector6d right = reduced[i];
    if (i + 1 < n) {
      backward[i] -= info.upper[i] * inverse(backward[i + 1]) * info.upper[i].transpose();
      right -= info.upper[i] * solution[i + 1];
    }
    solution[i] = forward_inverse[i] * right;
  }
  double corner = info.corner;
  for (std::size_t i = 0; i < n; ++i) corner -= info.border[i].dot(solution[i]);

  ChainCovariance out;
  out.corner = 1 / corner;
  out.diagonal.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Matrix6d m = inverse(forward[i] + backward[i] - info.diagonal[i]) +
                       solution[i] * out.corner * solution[i].transpose();
    out.diagonal[i] = (m + m.transpose()) / 2;
  }
  return out;
}

}  // namespace cf
