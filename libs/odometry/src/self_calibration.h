// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
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

/// When the lens of a UAV is looked for, and what is used from then on. Until it is settled no
/// keyframe should leave. It is settled from the start where k1 is known well enough: where its
/// sigma moves the corners by less than `threshold`.
class LensSearch {
 public:
  /// From the first `photos` photos; 0: every lens stays as given.
  explicit LensSearch(int photos) : photos_(photos) {}

  bool settled() const { return settled_; }
  /// To be called with the lens of the UAV's first photo.
  void begin(const CameraModel& given, double threshold);
  /// What a photo with this lens is to be used with.
  CameraModel use(const CameraModel& given) const;
  /// After each photo, and once more, `last`, after all: calibrates as soon as enough photos are
  /// posed, all in one segment and with one lens. Gives up after twice `photos`.
  void look(LocalMap& map, bool last, double threshold);

 private:
  const int photos_;
  bool settled_ = false;
  CameraModel given_;
  std::optional<CameraModel> found_;  ///< for `given_`
};

}  // namespace cf
