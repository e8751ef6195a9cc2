// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <optional>

#include "cf/geodesy/local_frame.h"

namespace cf {

/// The ENU frame at the origin that the folder's world.json gives; nothing where it says none.
/// Throws RunError on a world.json that cannot be understood.
std::optional<LocalFrame> worldFrameOf(const std::filesystem::path& folder);

/// T_ref_est of the ENU frames whose origins the two folders' world.json give; nothing where
/// either says none. Throws as worldFrameOf().
std::optional<Eigen::Isometry3d> transformBetweenWorlds(const std::filesystem::path& est_dir,
                                                        const std::filesystem::path& ref_dir);

}  // namespace cf
