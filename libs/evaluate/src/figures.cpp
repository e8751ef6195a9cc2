// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "figures.h"

#include <algorithm>
#include <cmath>

#include "statistics.h"

namespace cf {
namespace {

std::vector<double> magnitudesOf(const std::vector<double>& values) {
  std::vector<double> magnitudes;
  magnitudes.reserve(values.size());
  for (const double v : values) magnitudes.push_back(std::abs(v));
  return magnitudes;
}

}  // namespace

Json finite(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json triple(const Eigen::Vector3d& v) { return {finite(v.x()), finite(v.y()), finite(v.z())}; }

Json spreadOf(const std::vector<double>& errors) {
  if (errors.empty()) return nullptr;
  const std::vector<double> magnitudes = magnitudesOf(errors);
  return {{"count", errors.size()},
          {"bias", median(errors)},
          {"nmad", nmad(errors)},
          {"rms", rms(errors)},
          {"median", median(magnitudes)},
          {"p90", quantile(magnitudes, 0.9)},
          {"p95", quantile(magnitudes, 0.95)},
          {"max", *std::max_element(magnitudes.begin(), magnitudes.end())}};
}

Json sizeOf(const std::vector<double>& magnitudes) {
  if (magnitudes.empty()) return nullptr;
  return {{"median", median(magnitudes)}, {"p95", quantile(magnitudes, 0.95)}};
}

Json meanSquareOf(const std::vector<double>& normalised) {
  if (normalised.empty()) return nullptr;
  const auto n = static_cast<double>(normalised.size());
  const double mean = rms(normalised) * rms(normalised);
  const double low = chiSquareQuantile(0.025, n) / n, high = chiSquareQuantile(0.975, n) / n;
  return {{"count", normalised.size()},
          {"mean_square", finite(mean)},
          {"chi2_95", {low, high}},
          {"inside", mean >= low && mean <= high}};
}

Json consistencyOf(const std::vector<double>& normalised) {
  if (normalised.empty()) return nullptr;
  const std::vector<double> magnitudes = magnitudesOf(normalised);
  const auto below = [&](double limit) {
    return static_cast<double>(std::count_if(magnitudes.begin(), magnitudes.end(),
                                             [limit](double m) { return m < limit; })) /
           static_cast<double>(magnitudes.size());
  };
  return {{"count", magnitudes.size()},
          {"median", median(magnitudes)},
          {"within_1_sigma", below(1)},
          {"within_2_sigma", below(2)},
          {"within_3_sigma", below(3)}};
}

}  // namespace cf
