// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>

#include "cf/deliver/run_record.h"
#include "cf/geodesy/local_frame.h"

namespace cf {

/// The frame of a map that is not relative.
LocalFrame frameOf(const WorldRecord& world);

/// Longitude and latitude [deg], height [m] of a world position, rounded to 0.1 mm so that they
/// stay short in text.
std::array<double, 3> lonLatHeight(const LocalFrame& frame, const Eigen::Vector3d& p_world);

}  // namespace cf
