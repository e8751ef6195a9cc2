// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <vector>

namespace cf {

using Json = nlohmann::ordered_json;

/// JSON has no NaN or infinity: unknown is null.
Json finite(double value);
Json triple(const Eigen::Vector3d& v);

/// Of signed errors: count, bias (median), nmad, rms, and median, p90, p95, max of the magnitudes.
/// null if there are none.
Json spreadOf(const std::vector<double>& errors);
/// Median and p95 of magnitudes; null if there are none.
Json sizeOf(const std::vector<double>& magnitudes);

/// Mean square of independent errors over their sigmas, 1 if the sigmas are right, beside the 95 %
/// of chi-square that it should lie in. null if there are none.
Json meanSquareOf(const std::vector<double>& normalised);

/// Of errors over their sigmas: shares below 1, 2 and 3, and the median of the magnitude (0.674 if
/// the sigmas are right and the errors Gaussian). null if there are none.
Json consistencyOf(const std::vector<double>& normalised);

}  // namespace cf
