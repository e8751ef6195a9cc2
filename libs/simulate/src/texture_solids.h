// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "buildings.h"
#include "texture_materials.h"

namespace cf {

/// Adds what a place on a part of a building or car looks like over a footprint [m].
void paintPart(std::size_t sample, const Part& part, const Eigen::Vector3f& position,
               float footprint, Fragments& fragments);

}  // namespace cf
