// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "segment.h"

namespace cf {
namespace {

constexpr double kHorizontalGate = 15.2;  ///< chi-square, 2 degrees of freedom, 0.9995
constexpr double kVerticalGate = 12.1;    ///< 1 degree of freedom, 0.9995
constexpr int kFewestGated = 6;           ///< with fewer fixes none is called an outlier
constexpr double kMostCorrelated = 0.97;  ///< a colour factor of 8

}  // namespace

NoiseSums& NoiseSums::operator+=(const NoiseSums& o) {
  square += o.square;
  count += o.count;
  residual += o.residual;
  lagged += o.lagged;
  pairs += o.pairs;
  return *this;
}

Noise noiseOf(const NoiseSums& sums, double prior_dof) {
  Noise noise;
  for (int k = 0; k < 3; ++k) {
    noise.factor[k] = std::sqrt((prior_dof + sums.square[k]) / (prior_dof + sums.count[k]));
    if (sums.pairs[k] < 1 || sums.residual[k] <= 0) continue;
    // White noise reaches 2/sqrt(n) by chance.
    const double r = sums.lagged[k] / sums.residual[k];
    if (r < 2 / std::sqrt(sums.pairs[k])) continue;
    const double bounded = std::min(r, kMostCorrelated);
    noise.colour[k] = std::sqrt((1 + bounded) / (1 - bounded));
  }
  return noise;
}

Noise measuredNoise(const std::vector<Segment>& segments, const GeoreferenceOptions& options) {
  NoiseSums sums;
  for (const Segment& segment : segments) sums += segment.noise;
  return noiseOf(sums, options.prior_dof);
}

void gateFixes(Segment& segment, const Noise& noise) {
  const bool enough = segment.fixes() >= kFewestGated;
  for (Node& node : segment.nodes) {
    node.horizontal_outlier = node.vertical_outlier = false;
    if (!node.fix || !enough) continue;
    const Eigen::Vector3d e = (node.T_world_cam.translation() - node.fix->position_m)
                                  .cwiseQuotient(node.fix->sigma_m.cwiseProduct(noise.factor));
    node.horizontal_outlier = e.head<2>().squaredNorm() > kHorizontalGate;
    node.vertical_outlier = e.z() * e.z() > kVerticalGate;
  }
}

void measureNoise(Segment& segment, const Noise& used) {
  NoiseSums sums;
  const Node* before[3] = {nullptr, nullptr, nullptr};
  const auto error = [](const Node& node, int k) {
    return (node.T_world_cam.translation()[k] - node.fix->position_m[k]) / node.fix->sigma_m[k];
  };
  for (const Node& node : segment.nodes)
    for (int k = 0; k < 3; ++k) {
      if (!node.fix || (k < 2 ? node.horizontal_outlier : node.vertical_outlier)) continue;
      // Expectation of the squared error of a fix: the residual, plus what the pose is uncertain
      // by (at the weight of white noise).
      const double e = error(node, k), sigma = node.fix->sigma_m[k] * used.colour[k];
      sums.square[k] += e * e + node.covariance(k, k) / (sigma * sigma);
      ++sums.count[k];
      if (before[k]) {
        const double e_before = error(*before[k], k);
        sums.lagged[k] += e * e_before;
        sums.residual[k] += (e * e + e_before * e_before) / 2;
        ++sums.pairs[k];
      }
      before[k] = &node;
    }
  segment.noise = sums;
}

}  // namespace cf
