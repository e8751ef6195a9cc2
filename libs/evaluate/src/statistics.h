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

/// The value below which a chi-square variable of so many degrees of freedom lies with probability
/// `p`, by Wilson and Hilferty's cube root (3 % off at p = 0.025 with 6 degrees, less above).
double chiSquareQuantile(double p, double degrees_of_freedom);

}  // namespace cf
