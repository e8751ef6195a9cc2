// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cf/align/aligner.h"
#include "cf/types/sim3.h"

namespace cf {

/// Moves the whole map by a similarity: poses, points, depths, relative poses and what is told of
/// their errors. Photos see their points as before; cameras stay. The GNSS biases grow by what the
/// photos of their UAV have moved, in the mean.
void moveMap(const Sim3& S_new_old, Alignment& alignment);

}  // namespace cf
