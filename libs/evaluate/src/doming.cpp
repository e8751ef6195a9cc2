// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/evaluate/doming.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "statistics.h"

namespace cf {
namespace {

constexpr std::size_t kFitted = 100'000;
constexpr int kRounds = 4;  ///< fits, each without what lies beyond 3 sigma of the last

/// The fit in coordinates about the middle of the places, 1 at the farthest of them.
struct Quadratic {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  double reach = 0;
  Eigen::Matrix<double, 6, 1> factors = Eigen::Matrix<double, 6, 1>::Zero();

  Eigen::Matrix<double, 6, 1> terms(const Eigen::Vector2d& place) const {
    const Eigen::Vector2d p = (place - middle) / reach;
    Eigen::Matrix<double, 6, 1> t;
    t << 1, p.x(), p.y(), p.x() * p.x(), p.x() * p.y(), p.y() * p.y();
    return t;
  }
  double bend(const Eigen::Vector2d& place) const {
    return terms(place).tail<3>().dot(factors.tail<3>());
  }
};

Result<Quadratic> fit(const std::vector<Eigen::Vector2d>& places,
                      const std::vector<double>& errors) {
  if (places.size() < 6) return Failure{"too_few_places", "fewer than 6 places"};
  Quadratic out;
  for (const auto& p : places) out.middle += p / static_cast<double>(places.size());
  for (const auto& p : places) out.reach = std::max(out.reach, (p - out.middle).norm());
  if (!(out.reach > 0)) return Failure{"one_place", "all places coincide"};
  const std::size_t step = (places.size() - 1) / kFitted + 1, n = (places.size() - 1) / step + 1;
  Eigen::Matrix<double, Eigen::Dynamic, 6> A(static_cast<Eigen::Index>(n), 6);
  Eigen::VectorXd b(static_cast<Eigen::Index>(n));
  for (std::size_t i = 0; i < n; ++i) {
    A.row(static_cast<Eigen::Index>(i)) = out.terms(places[i * step]).transpose();
    b[static_cast<Eigen::Index>(i)] = errors[i * step];
  }
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(A);
  if (qr.rank() < 6) return Failure{"undetermined", "the places lie on one line"};
  out.factors = qr.solve(b);
  return out;
}

}  // namespace

Result<Doming> domingOf(const std::vector<Eigen::Vector2d>& places_m,
                        const std::vector<double>& errors_m) {
  const Result<Quadratic> quadratic = fit(places_m, errors_m);
  if (!quadratic) return quadratic.failure();
  Eigen::ArrayXd bend(static_cast<Eigen::Index>(places_m.size()));
  for (std::size_t i = 0; i < places_m.size(); ++i)
    bend[static_cast<Eigen::Index>(i)] = quadratic->bend(places_m[i]);
  return Doming{bend.maxCoeff() - bend.minCoeff(), std::sqrt((bend - bend.mean()).square().mean())};
}

Result<std::vector<double>> withoutBend(const std::vector<Eigen::Vector2d>& places_m,
                                        const std::vector<double>& errors_m) {
  std::vector<Eigen::Vector2d> places = places_m;
  std::vector<double> errors = errors_m, left;
  for (int round = 0; round < kRounds; ++round) {
    const Result<Quadratic> quadratic = fit(places, errors);
    if (!quadratic) return quadratic.failure();
    left = errors_m;
    for (std::size_t i = 0; i < left.size(); ++i)
      left[i] -= quadratic->terms(places_m[i]).dot(quadratic->factors);
    const double limit = 3 * nmad(left), middle = median(left);
    places.clear();
    errors.clear();
    for (std::size_t i = 0; i < left.size(); ++i)
      if (std::abs(left[i] - middle) <= limit) {
        places.push_back(places_m[i]);
        errors.push_back(errors_m[i]);
      }
  }
  return left;
}

}  // namespace cf
