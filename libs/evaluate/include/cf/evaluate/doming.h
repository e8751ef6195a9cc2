// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "cf/base/result.h"

namespace cf {

/// The bend of a map: of the least-squares fit 1, x, y, x^2, xy, y^2 of the vertical error, the
/// last three terms about the middle of the map.
struct Doming {
  double span_m = 0;  ///< largest minus smallest over the places
  double rms_m = 0;   ///< about their mean
};

/// What is left of the errors after the whole fit, which gross errors do not pull; fails as
/// domingOf() does. The fit is to every n-th place of many.
Result<std::vector<double>> withoutBend(const std::vector<Eigen::Vector2d>& places_m,
                                        const std::vector<double>& errors_m);

/// Fails on fewer than 6 places, or such as do not determine the fit.
Result<Doming> domingOf(const std::vector<Eigen::Vector2d>& places_m,
                        const std::vector<double>& errors_m);

}  // namespace cf
