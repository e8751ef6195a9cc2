// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace cf {

/// Cuts a flight where its track turns: the strip of each photo, counted from 0 in time order.
/// `track` holds horizontal positions [m] in time order; photos without one join the strip before.
///
/// The track is cut into straight pieces by dynamic programming (least squares of the distance to
/// each piece's line, in units of the noise, plus a price per piece), then where it reverses on the
/// same line; pieces much shorter than the others (the turns) are shared out to their neighbours.
/// The noise is estimated from the track itself. Empty if fewer than two photos have a position.
std::vector<int> stripsOf(const std::vector<std::optional<Eigen::Vector2d>>& track);

}  // namespace cf
