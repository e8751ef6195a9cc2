// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace cf {

/// Gives memory that is free, but kept for later, back to the system: images and points of changing
/// sizes leave holes that add up to hundreds of MB.
void releaseFreeMemory();

/// That this process holds now.
double residentMegabytes();

}  // namespace cf
