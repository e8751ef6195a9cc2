// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace cf {

/// Value below which `share` of the values lie; 0 of none.
inline double quantileOf(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  const auto rank = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return values[static_cast<std::size_t>(rank)];
}

inline double medianOf(std::vector<double> values) { return quantileOf(std::move(values), 0.5); }

/// Standard deviation of normal values that wrong ones do not pull: 1.4826 times the median
/// absolute deviation from the median.
inline double robustSigma(const std::vector<double>& values) {
  const double middle = medianOf(values);
  std::vector<double> deviations;
  for (const double v : values) deviations.push_back(std::abs(v - middle));
  return 1.4826 * medianOf(std::move(deviations));
}

}  // namespace cf
