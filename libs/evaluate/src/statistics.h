// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>
#include <vector>

namespace cf {

/// The value below which the fraction `q` of the values lies, linear between neighbours; values
/// must not be empty.
double quantile(std::vector<double> values, double q);
inline double median(std::vector<double> values) { return quantile(std::move(values), 0.5); }
double rms(const std::vector<double>& values);
/// 1.4826 times the median of |value - median|: sigma, if the values are Gaussian.
double nmad(std::vector<double> values);

}  // namespace cf
