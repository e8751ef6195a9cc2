// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "world_origin.h"

namespace cf {

Eigen::Isometry3d transformBetweenWorlds(const std::filesystem::path&,
                                         const std::filesystem::path&) {
  return Eigen::Isometry3d::Identity();
}

}  // namespace cf
