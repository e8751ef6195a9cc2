// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "local_map.h"

namespace cf {

/// Radial distortion from the first photos of a UAV: k1 and k2 under the priors of the camera as
/// given, adjusted together with the poses and landmarks of `photos`, which are of one lens and one
/// segment, and none of them final. Focal length and principal point are held: level flights do not
/// tell them. An unknown distortion bends every strip; known to a tenth it hardly does.
///
/// Where the fit is far better than with the lens as given, the cameras, poses and landmarks of the
/// photos become those found, and sights that do not fit are removed. Otherwise nothing changes,
/// and it returns false. `threshold` as in adjustLocally().
bool calibrateRadial(LocalMap& map, const std::vector<PhotoIndex>& photos, double threshold);

}  // namespace cf
