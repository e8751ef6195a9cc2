// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "gnss_residuals.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "robust.h"

namespace cf {
namespace {

constexpr int kRounds = 5;         ///< of reweighting
constexpr double kTukey = 4.685;   ///< its constant, in σ
constexpr std::size_t kSpare = 6;  ///< fixes beyond the unknowns

std::vector<double> axisOf(const std::vector<GnssResidual>& residuals, Eigen::Index axis) {
  std::vector<double> values;
  for (const GnssResidual& r : residuals) values.push_back(r.residual_m[axis]);
  return values;
}

/// Correlation of each value with the next, of the same UAV.
double correlationInTime(const Eigen::VectorXd& left, const std::vector<int>& uav) {
  double product = 0, square = 0;
  for (Eigen::Index i = 0; i + 1 < left.size(); ++i) {
    if (uav[static_cast<std::size_t>(i)] != uav[static_cast<std::size_t>(i + 1)]) continue;
    product += left[i] * left[i + 1];
    square += left[i] * left[i];
  }
  return square > 0 ? std::clamp(product / square, 0.0, 0.95) : 0;
}

}  // namespace

std::vector<GnssResidual> gnssResiduals(const UavRecord& uav) {
  std::vector<GnssResidual> residuals;
  for (const PhotoPose& pose : uav.final_trajectory) {
    const auto fix = uav.fixes.find(pose.photo);
    if (fix == uav.fixes.end()) continue;
    const Eigen::Vector3d place = pose.T_world_cam.translation();
    residuals.push_back({pose.photo, place, fix->second.position_m - place, fix->second.sigma_m});
  }
  return residuals;
}

Eigen::Vector3d gnssOffset(const std::vector<GnssResidual>& residuals) {
  Eigen::Vector3d offset;
  for (Eigen::Index axis = 0; axis < 3; ++axis) offset[axis] = medianOf(axisOf(residuals, axis));
  return offset;
}

double gnssNoiseRatio(const std::vector<GnssResidual>& residuals) {
  if (residuals.size() < 3) return 0;
  double sum = 0;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    std::vector<double> tagged;
    for (const GnssResidual& r : residuals) tagged.push_back(r.sigma_m[axis]);
    const double ratio =
        robustSigma(axisOf(residuals, axis)) / std::max(1e-3, medianOf(std::move(tagged)));
    sum += ratio * ratio / 3;
  }
  return std::sqrt(sum);
}

std::optional<Bend> bendAgainstGnss(const RunRecord& run) {
  std::vector<GnssResidual> all;
  std::vector<int> of_uav;
  int uavs = 0;
  for (const UavRecord& uav : run.uavs) {
    const auto residuals = gnssResiduals(uav);
    if (residuals.empty()) continue;
    all.insert(all.end(), residuals.begin(), residuals.end());
    of_uav.insert(of_uav.end(), residuals.size(), uavs++);
  }
  const auto n = static_cast<Eigen::Index>(all.size()), unknowns = Eigen::Index{uavs + 5};
  if (all.size() < static_cast<std::size_t>(unknowns) + kSpare) return std::nullopt;
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const GnssResidual& r : all) middle += r.place_m.head<2>() / static_cast<double>(n);
  double reach = 0;
  for (const GnssResidual& r : all) reach = std::max(reach, (r.place_m.head<2>() - middle).norm());
  if (!(reach > 0)) return std::nullopt;

  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, unknowns);
  Eigen::VectorXd b(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const GnssResidual& r = all[static_cast<std::size_t>(i)];
    const Eigen::Vector2d p = (r.place_m.head<2>() - middle) / reach;
    A(i, of_uav[static_cast<std::size_t>(i)]) = 1;
    A.row(i).tail<5>() << p.x(), p.y(), p.x() * p.x(), p.x() * p.y(), p.y() * p.y();
    b[i] = r.residual_m.z();
  }
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(n), factors, left;
  double sigma = 0;
  Eigen::MatrixXd covariance;
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::VectorXd root = weights.cwiseSqrt();
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(root.asDiagonal() * A);
    if (qr.rank() < unknowns) return std::nullopt;
    factors = qr.solve(root.cwiseProduct(b));
    left = b - A * factors;
    sigma = std::max(1e-6, robustSigma({left.data(), left.data() + n}));
    covariance = (A.transpose() * weights.asDiagonal() * A).inverse();
    for (Eigen::Index i = 0; i < n; ++i) {
      const double t = left[i] / (kTukey * sigma);
      weights[i] = std::abs(t) < 1 ? (1 - t * t) * (1 - t * t) : 0;
    }
  }
  const Eigen::VectorXd bend = A.rightCols<3>() * factors.tail<3>();
  Eigen::Index high = 0, low = 0;
  Bend out;
  out.span_m = bend.maxCoeff(&high) - bend.minCoeff(&low);
  const Eigen::Vector3d span = (A.row(high) - A.row(low)).tail<3>().transpose();
  const double in_time = correlationInTime(left, of_uav);
  const double fewer = (1 + in_time) / (1 - in_time);
  out.sigma_m = sigma * std::sqrt(fewer * span.dot(covariance.bottomRightCorner<3, 3>() * span));
  return out;
}

}  // namespace cf
