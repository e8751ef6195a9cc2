// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "scene_plan.h"

namespace cf {

/// A crown of half extent 1 about the origin, to be scaled where it stands.
struct CrownMesh {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::uint32_t> corners;  ///< three a triangle
};

/// An irregular leafy surface: lumps over lumps. A few of them, scaled and turned, make a wood.
CrownMesh makeCrown(Greenery kind, std::uint64_t seed);

}  // namespace cf
