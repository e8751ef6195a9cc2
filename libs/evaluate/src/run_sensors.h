// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cf/types/camera_model.h"
#include "run_inputs.h"
#include "run_section.h"

namespace cf {

/// Distance between the pixels at which two cameras see the same ray, over the photo of the first.
struct PixelDisplacement {
  double rms_px = 0, max_px = 0;
};
PixelDisplacement displacementOf(const CameraModel& truth, const CameraModel& estimate);

/// Focal length and image geometry of each UAV's camera, as given and as estimated.
RunSection cameraFigures(const RunInputs& run);

/// Noise and bias of each UAV's receiver. A shift of all the map is not observable: the mean
/// difference of the biases is told apart from what is left.
RunSection gnssFigures(const RunInputs& run);

}  // namespace cf
