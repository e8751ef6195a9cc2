// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <optional>

namespace cf {

/// T_ref_est of the ENU frames whose origins the two folders' world.json give; nothing where
/// either says none. Throws RunError on a world.json that cannot be understood.
std::optional<Eigen::Isometry3d> transformBetweenWorlds(const std::filesystem::path& est_dir,
                                                        const std::filesystem::path& ref_dir);

}  // namespace cf
