// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "geographic.h"

#include <cmath>

namespace cf {
namespace {

double rounded(double value, double step) { return std::round(value / step) * step; }

}  // namespace

LocalFrame frameOf(const WorldRecord& world) {
  return LocalFrame(world.latitude_deg, world.longitude_deg, world.height_m);
}

std::array<double, 3> lonLatHeight(const LocalFrame& frame, const Eigen::Vector3d& p_world) {
  const Geodetic g = frame.toGeodetic(p_world);
  return {rounded(g.longitude_deg, 1e-9), rounded(g.latitude_deg, 1e-9), rounded(g.height_m, 1e-4)};
}

}  // namespace cf
