// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "ground_scale.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <string>

#include "cf/base/median.h"

namespace cf {
namespace {

constexpr std::size_t kFewest = 30;
/// Median departure from the plane, relative to the depth.
constexpr double kRoughest = 0.06;
constexpr int kRounds = 15;

}  // namespace

Result<double> scaleByGround(const std::vector<GroundSight>& known,
                             const std::vector<GroundSight>& measured) {
  if (std::min(known.size(), measured.size()) < kFewest)
    return Failure{"few_depths", std::to_string(known.size()) + " known and " +
                                     std::to_string(measured.size()) + " measured depths, " +
                                     std::to_string(kFewest) + " needed"};
  // The plane (3) and the inverse of the scale: plane . x = 1/z known, plane . x = s 1/z measured.
  Eigen::Vector4d fit = Eigen::Vector4d::Zero();
  const std::vector<GroundSight>* sets[] = {&known, &measured};
  std::vector<double> weight[2], departure[2];
  for (int s = 0; s < 2; ++s) {
    weight[s].assign(sets[s]->size(), 1 / static_cast<double>(sets[s]->size()));
    departure[s].assign(sets[s]->size(), 0);
  }
  const auto row = [](const GroundSight& sight, int set) {
    Eigen::Vector4d r;
    r << sight.normalized.homogeneous(), set == 0 ? 0 : -sight.inverse_depth;
    return r;
  };
  double rough = 0;
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix4d N = Eigen::Matrix4d::Zero();
    Eigen::Vector4d g = Eigen::Vector4d::Zero();
    for (int s = 0; s < 2; ++s)
      for (std::size_t i = 0; i < sets[s]->size(); ++i) {
        const Eigen::Vector4d r = row((*sets[s])[i], s);
        N += weight[s][i] * r * r.transpose();
        if (s == 0) g += weight[s][i] * (*sets[s])[i].inverse_depth * r;
      }
    fit = N.ldlt().solve(g);
    if (!fit.allFinite() || !(fit[3] > 0)) return Failure{"rough_ground", "no plane fits"};
    rough = 0;
    for (int s = 0; s < 2; ++s) {
      for (std::size_t i = 0; i < sets[s]->size(); ++i) {
        const GroundSight& sight = (*sets[s])[i];
        const double inverse = s == 0 ? sight.inverse_depth : fit[3] * sight.inverse_depth;
        const double plane = fit.head<3>().dot(sight.normalized.homogeneous());
        departure[s][i] = std::abs((inverse - plane) / plane);
      }
      const double usual = upperMedian(departure[s]);
      rough = std::max(rough, usual);
      for (std::size_t i = 0; i < sets[s]->size(); ++i) {
        const double e = departure[s][i] / std::max(1e-9, 2 * usual);
        weight[s][i] = 1 / ((1 + e * e) * static_cast<double>(sets[s]->size()));
      }
    }
  }
  if (rough > kRoughest)
    return Failure{"rough_ground", std::to_string(100 * rough) + " % median departure"};
  return 1 / fit[3];
}

}  // namespace cf
