// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cf/base/options.h"
#include "cf/features/extract.h"
#include "cf/types/image_frame.h"
#include "cf/types/keyframe.h"

namespace cf {

/// Section [odometry].
struct OdometryOptions {
  FeatureOptions features;
  int match_window = 5;          ///< earlier photos that each photo is matched to
  double match_ratio = 0.85;     ///< Lowe's ratio: best over second best descriptor distance
  double inlier_px = 3.0;        ///< reprojection threshold at the feature size [px]
  int min_inliers = 20;          ///< below, a photo is not tracked
  int adjustment_window = 7;     ///< photos in the local bundle adjustment
  int keyframe_features = 2000;  ///< that a keyframe carries to the central node
  int delay = 2;                 ///< photos that must follow before a keyframe is final
  /// First photos of a UAV from which an uncertain radial distortion is estimated before any of
  /// them is final; 0: the lens stays as given.
  int calibration_photos = 6;

  void visit(OptionVisitor& v);
};

/// What odometry takes from the pixels of a photo.
struct PreparedPhoto {
  FeatureSet features;
  cv::Mat grey;  ///< that patches are aligned in
};

/// Needs no state: may be done ahead, for several photos at a time. `frame.image` must be decoded.
PreparedPhoto preparePhoto(const ImageFrame& frame, const OdometryOptions& options);

/// Monocular visual odometry of one UAV: every photo becomes a keyframe with a pose in the local
/// frame of its segment (that of its first photo; its unit, VO units, is arbitrary). Photos are
/// matched to the last few, posed by resection (or, where no segment can be continued, by two-view
/// geometry, which opens a new one) and refined by a local bundle adjustment with inverse depths,
/// equations (2) and (3). A keyframe leaves once `delay` later photos have come; from then on its
/// pose is fixed: the local frame never jumps. The first ones wait until the radial distortion has
/// been estimated from them, if it was given with a sigma that matters: keyframes carry the camera
/// found. Nothing fails: a photo that cannot be tracked is alone in its segment. Deterministic; no
/// threads.
class Odometry {
 public:
  explicit Odometry(const OdometryOptions& options);
  ~Odometry();
  Odometry(Odometry&&) noexcept;

  /// `frame.image` must be decoded; frames come in time order. Returns the keyframes that became
  /// final.
  std::vector<std::shared_ptr<const Keyframe>> push(const ImageFrame& frame);
  /// The same with what preparePhoto() made of the photo; `frame.image` may be empty.
  std::vector<std::shared_ptr<const Keyframe>> push(const ImageFrame& frame, PreparedPhoto photo);
  /// No more photos come: all that wait.
  std::vector<std::shared_ptr<const Keyframe>> flush();

  /// The photos that are not final, in order, as known now: segment (-1: not posed yet), pose,
  /// matches, inliers, without features. For the live display and the online trajectory.
  std::vector<Keyframe> provisional() const;

 private:
  class Tracker;
  std::unique_ptr<Tracker> tracker_;
};

}  // namespace cf
