// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cf/base/time.h"
#include "cf/types/camera_model.h"
#include "cf/types/feature_set.h"
#include "cf/types/gnss_fix.h"
#include "cf/types/ids.h"
#include "cf/types/image_frame.h"

namespace cf {

/// A photo after odometry: a pose in its segment's local frame, which never jumps. Immutable.
/// A photo that could not be tracked to any other is the only one of its segment.
struct Keyframe {
  FrameId id;
  TimeNs time = 0;
  std::string name;
  int segment = 0;
  Eigen::Isometry3d T_local_cam = Eigen::Isometry3d::Identity();  ///< VO units
  CameraModel camera;                                             ///< as used by odometry
  std::shared_ptr<const FeatureSet> features;
  /// Per feature: inverse depth along the camera's z axis [1/VO unit]; 0 = not triangulated.
  std::vector<float> inverse_depth;
  /// Per feature: the landmark whose first sight it was aligned with by grey values; -1 = none.
  /// Features of one UAV with the same number agree to a fraction of what a detector can.
  std::vector<int> chain;
  std::optional<GimbalAttitude> attitude;
  std::optional<double> height_above_ground_m;
  int matches = 0;  ///< feature matches to earlier photos
  int inliers = 0;  ///< of them consistent with the pose
};

/// A keyframe with its pose in the world. What crosses the seam to the central node, once.
struct GeoKeyframe {
  std::shared_ptr<const Keyframe> keyframe;
  std::optional<GnssPosition> fix;  ///< interpolated to the photo's time; none in an outage
};

/// The georeference of one segment at one time, as the UAV knows it alone. A later version
/// replaces an earlier one as a whole.
struct GeoSegment {
  SegmentId id;
  bool georeferenced = false;  ///< false: too few fixes; poses are in the local frame
  double scale = 1;            ///< metres per VO unit
  double scale_sigma = 0;
  struct Pose {
    FrameId frame;
    Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
    Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
    ///< order: translation [m] in world, rotation vector [rad] in world (left perturbation)
  };
  std::vector<Pose> poses;  ///< by frame index
};

/// What is known of the GNSS receiver of one UAV.
struct GnssQuality {
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();  ///< per axis, estimated from residuals
  Eigen::Vector3d bias_m = Eigen::Vector3d::Zero();   ///< against the joint map; zero if unknown
  int fixes = 0;
  int outliers = 0;
  bool trusted = false;
};

}  // namespace cf
