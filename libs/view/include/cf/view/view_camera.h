// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>

#include "cf/view/scene_inputs.h"

namespace cf {

struct ImageSize {
  int width = 1920;
  int height = 1080;
};

/// "1920x1080"; throws UsageError on anything else or outside 64..16384.
ImageSize parseImageSize(const std::string& text);

/// Which picture. Text form: top | iso | front | uav:<name> | octomap | height.
struct View {
  enum class Kind { kTop, kIso, kFront, kUav, kOctomap, kHeight };
  Kind kind = Kind::kTop;
  std::string uav;  ///< for kUav
};

/// Throws UsageError naming the views that exist.
View parseView(const std::string& text);

/// From where the world is seen: MRPT's orbit camera. Azimuth -90 looks north, elevation 90 looks
/// straight down with north up.
struct ViewCamera {
  static constexpr double kFieldOfViewDeg = 30;  ///< vertical, perspective only

  ImageSize size;
  bool orthographic = false;
  Eigen::Vector3d target_m = Eigen::Vector3d::Zero();  ///< in the middle of the picture
  double azimuth_deg = -90;
  double elevation_deg = 90;
  double distance_m = 100;  ///< from eye to target, perspective
  double height_m = 100;    ///< visible height of the picture, orthographic
  double near_m = 1, far_m = 1000;

  Eigen::Vector3d right() const;
  Eigen::Vector3d up() const;
  Eigen::Vector3d forward() const;
  Eigen::Vector3d eye() const;
  double depth(const Eigen::Vector3d& p_world) const { return forward().dot(p_world - eye()); }
  /// World point to pixel of the picture; (0,0) is the centre of the top-left pixel.
  Eigen::Vector2d project(const Eigen::Vector3d& p_world) const;
  /// Metres that one pixel covers at a depth.
  double metresPerPixel(double depth_m) const;
};

/// A camera that shows the robust extent of the scene: the 0.5 to 99.5 percentile of the
/// cloud and every camera centre; for uav:<name>, those of that UAV and the ground around it.
/// Throws UsageError for a UAV that the run does not have, RunError for an empty scene.
ViewCamera frameScene(const SceneInputs& scene, const View& view, ImageSize size);

}  // namespace cf
