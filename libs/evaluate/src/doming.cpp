// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/evaluate/doming.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace cf {

Result<Doming> domingOf(const std::vector<Eigen::Vector2d>& places_m,
                        const std::vector<double>& errors_m) {
  if (places_m.size() < 6) return Failure{"too_few_places", "fewer than 6 places"};
  const auto n = static_cast<Eigen::Index>(places_m.size());
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const auto& p : places_m) middle += p / static_cast<double>(n);
  double reach = 0;
  for (const auto& p : places_m) reach = std::max(reach, (p - middle).norm());
  if (!(reach > 0)) return Failure{"one_place", "all places coincide"};
  Eigen::Matrix<double, Eigen::Dynamic, 6> A(n, 6);
  Eigen::VectorXd b(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Eigen::Vector2d p = (places_m[k] - middle) / reach;
    A.row(i) << 1, p.x(), p.y(), p.x() * p.x(), p.x() * p.y(), p.y() * p.y();
    b[i] = errors_m[k];
  }
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(A);
  if (qr.rank() < 6) return Failure{"undetermined", "the places lie on one line"};
  const Eigen::VectorXd bend = A.rightCols<3>() * qr.solve(b).tail<3>();
  return Doming{bend.maxCoeff() - bend.minCoeff(),
                std::sqrt((bend.array() - bend.mean()).square().mean())};
}

}  // namespace cf
