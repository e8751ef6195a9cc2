// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/geometry/similarity.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <random>

namespace cf {
namespace {

constexpr int kMostRounds = 500;
constexpr double kMissed = 1e-6;  ///< chance that no sample was without outlier

struct Moments {
  Eigen::Vector3d mean_a = Eigen::Vector3d::Zero(), mean_b = Eigen::Vector3d::Zero();
  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();  ///< sum w (a - mean_a)(b - mean_b)'
  double var_b = 0;
};

Moments momentsOf(const std::vector<Eigen::Vector3d>& a, const std::vector<Eigen::Vector3d>& b,
                  const std::vector<double>& weights) {
  Moments m;
  double sum = 0;
  const auto weight = [&](std::size_t i) { return weights.empty() ? 1.0 : weights[i]; };
  for (std::size_t i = 0; i < a.size(); ++i) {
    m.mean_a += weight(i) * a[i];
    m.mean_b += weight(i) * b[i];
    sum += weight(i);
  }
  m.mean_a /= sum;
  m.mean_b /= sum;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Eigen::Vector3d da = a[i] - m.mean_a, db = b[i] - m.mean_b;
    m.cross += weight(i) / sum * da * db.transpose();
    m.var_b += weight(i) / sum * db.squaredNorm();
  }
  return m;
}

}  // namespace

Result<Sim3> alignPoints(const std::vector<Eigen::Vector3d>& a,
                         const std::vector<Eigen::Vector3d>& b, AlignmentModel model,
                         const std::vector<double>& weights) {
  const std::size_t needed = model == AlignmentModel::kYaw4 ? 2 : 3;
  if (a.size() != b.size() || a.size() < needed)
    return Failure{"too_few_points", "alignment needs " + std::to_string(needed) + " pairs, got " +
                                         std::to_string(std::min(a.size(), b.size()))};
  const Moments m = momentsOf(a, b, weights);
  Sim3 S;
  if (model == AlignmentModel::kYaw4) {
    const double yaw = std::atan2(m.cross(1, 0) - m.cross(0, 1), m.cross(0, 0) + m.cross(1, 1));
    S.rotation = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  } else {
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m.cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
    if (svd.singularValues()(1) < 1e-9 * svd.singularValues()(0) || m.var_b <= 0)
      return Failure{"collinear", "the points lie on one line: the rotation about it is free"};
    Eigen::Vector3d sign(1, 1, 1);
    if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) sign.z() = -1;
    S.rotation = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
    if (model == AlignmentModel::kSim3) S.scale = svd.singularValues().dot(sign) / m.var_b;
  }
  S.translation = m.mean_a - S.scale * (S.rotation * m.mean_b);
  return S;
}

Result<RobustAlignment> alignPointsRobust(const std::vector<Eigen::Vector3d>& a,
                                          const std::vector<Eigen::Vector3d>& b,
                                          AlignmentModel model, double threshold, int min_inliers,
                                          unsigned seed) {
  const std::size_t sample = model == AlignmentModel::kYaw4 ? 2 : 3;
  if (a.size() < std::max<std::size_t>(sample, static_cast<std::size_t>(min_inliers)))
    return Failure{"too_few_points", std::to_string(a.size()) + " pairs"};
  std::mt19937 random(seed);
  RobustAlignment best;
  const auto classify = [&](const Sim3& S) {
    RobustAlignment result{S, std::vector<char>(a.size(), 0), 0};
    for (std::size_t i = 0; i < a.size(); ++i)
      if ((a[i] - S * b[i]).norm() < threshold) {
        result.inlier[i] = 1;
        ++result.inliers;
      }
    return result;
  };
  const auto subsetOf = [&](const std::vector<Eigen::Vector3d>& all,
                            const std::vector<char>& keep) {
    std::vector<Eigen::Vector3d> out;
    for (std::size_t i = 0; i < all.size(); ++i)
      if (keep[i]) out.push_back(all[i]);
    return out;
  };
  std::vector<Eigen::Vector3d> sa(sample), sb(sample);
  int rounds = kMostRounds;
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t k = 0; k < sample; ++k) {
      const std::size_t i = random() % a.size();
      sa[k] = a[i];
      sb[k] = b[i];
    }
    const auto S = alignPoints(sa, sb, model);
    if (!S || !std::isfinite(S->scale) || S->scale <= 0) continue;
    RobustAlignment candidate = classify(*S);
    if (candidate.inliers <= best.inliers) continue;
    best = std::move(candidate);
    const double share = static_cast<double>(best.inliers) / static_cast<double>(a.size());
    const double pure = std::pow(share, static_cast<double>(sample));  // a sample without outlier
    const double enough = std::log(kMissed) / std::log1p(-pure);  // beyond any int for few inliers
    if (enough < rounds) rounds = static_cast<int>(enough) + 1;
  }
  for (int round = 0; round < 5 && best.inliers >= min_inliers; ++round) {
    const auto S = alignPoints(subsetOf(a, best.inlier), subsetOf(b, best.inlier), model);
    if (!S) break;
    // Even if a few pairs fewer agree: the fit to all of them is nearer the truth than the sample
    // that chanced to please most.
    RobustAlignment refined = classify(*S);
    const bool settled = refined.inlier == best.inlier;
    best = std::move(refined);
    if (settled) break;
  }
  if (best.inliers < min_inliers)
    return Failure{"too_few_inliers", std::to_string(best.inliers) + " of " +
                                          std::to_string(a.size()) + " pairs agree, " +
                                          std::to_string(min_inliers) + " needed"};
  return best;
}

}  // namespace cf
