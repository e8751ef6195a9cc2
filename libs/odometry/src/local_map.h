// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <vector>

#include "cf/types/image_frame.h"
#include "cf/types/keyframe.h"

namespace cf {

/// Index of a photo in the order of its arrival at this UAV's odometry.
using PhotoIndex = int;

/// A photo inside odometry.
struct TrackedPhoto {
  ImageFrame frame;  ///< without pixels
  std::shared_ptr<FeatureSet> features;
  cv::Mat grey;                             ///< for the alignment of patches, while recent
  std::vector<Eigen::Vector2d> normalized;  ///< per feature
  std::vector<int> chain;                   ///< per feature, as a keyframe's
  std::vector<int> landmark;                ///< per feature; -1 = none
  int segment = -1;                         ///< -1: not posed yet
  Eigen::Isometry3d T_local_cam = Eigen::Isometry3d::Identity();
  bool final = false;  ///< has left as a keyframe: its pose is fixed
  int matches = 0;
};

struct LandmarkObservation {
  PhotoIndex photo = 0;
  int feature = 0;
};

/// A point on the ray of its anchor's feature: p_anchor = (u, v, 1) / inverse_depth, equation (2).
struct Landmark {
  double inverse_depth = 0;                       ///< [1/VO unit]; 0 = dropped
  std::vector<LandmarkObservation> observations;  ///< the first is the anchor
};

struct LocalMap {
  std::vector<TrackedPhoto> photos;
  std::vector<Landmark> landmarks;

  TrackedPhoto& photo(PhotoIndex i) { return photos[static_cast<std::size_t>(i)]; }
  const TrackedPhoto& photo(PhotoIndex i) const { return photos[static_cast<std::size_t>(i)]; }

  /// Position in the local frame of the landmark's segment.
  Eigen::Vector3d position(const Landmark& landmark) const {
    const LandmarkObservation& anchor = landmark.observations.front();
    const TrackedPhoto& host = photo(anchor.photo);
    const Eigen::Vector3d ray =
        host.normalized[static_cast<std::size_t>(anchor.feature)].homogeneous();
    return host.T_local_cam * Eigen::Vector3d(ray / landmark.inverse_depth);
  }
};

}  // namespace cf
