// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "cf/types/camera_model.h"

namespace cf {

/// What a photo's tags say about its focal length; 0 = not tagged.
struct FocalTags {
  double focal_mm = 0;
  double focal_35mm = 0;             ///< FocalLengthIn35mmFilm [mm]
  double focal_plane_px_per_mm = 0;  ///< FocalPlaneXResolution
  int original_width = 0;            ///< [px] that the focal plane resolution refers to
};

struct FocalEstimate {
  double focal_px = 0;
  double sigma_px = 0;
  std::string source;    ///< for people: "35 mm equivalent of 20 mm"
  bool assumed = false;  ///< nothing usable was tagged
};

/// Focal length in pixels of a photo of this size, possibly a reduced copy of the original:
/// 1. focal length times focal plane resolution, at the original width, scaled to this one;
/// 2. the 35 mm equivalent, by the diagonal (43.27 mm) of the uncropped sensor: a photo wider than
///    1.6:1 is a crop that keeps the width of a 4:3 sensor;
/// 3. 0.8 of the longer side, assumed.
/// Values that no camera has (a sensor under 3 mm, a field of view beyond 3..150 degrees) are
/// passed over. Sigma 5 %, when assumed 20 %.
FocalEstimate focalOf(const FocalTags& tags, int width, int height);

/// Camera with that focal length, the centre as principal point, and priors for k1, k2.
CameraModel cameraFrom(const FocalEstimate& focal, int width, int height);

}  // namespace cf
