// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "cf/densify/densify.h"
#include "cf/types/camera_model.h"

namespace cf::bench {

/// True depth along the optical axis [m] at every step-th pixel of a photo; 0 = nothing.
struct TrueDepth {
  int step = 1;
  cv::Mat values;  ///< CV_32FC1

  /// Bilinear on smooth surfaces, the nearest value at steps; 0 outside.
  double at(const Eigen::Vector2d& pixel) const;
};

/// A photo with the truth about it and the view that is handed to the matcher, which has the true
/// pose and camera or those of a run.
struct TruePhoto {
  std::string uav, name;
  std::filesystem::path image;
  Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();  ///< true
  CameraModel camera;                                             ///< true
  DenseView view;
  bool posed = true;  ///< by the run
};

/// A flight of cf-simulate with its truth.
class TruthFlight {
 public:
  /// Poses and cameras of the views are the true ones, or those of the run in `run` if not empty.
  TruthFlight(const std::filesystem::path& folder, const std::filesystem::path& run);

  const std::vector<TruePhoto>& photos() const { return photos_; }
  const TruePhoto& photo(FrameId id) const;
  /// Views of all photos with a pose.
  std::vector<DenseView> views() const;
  const TrueDepth& depth(const TruePhoto& photo) const { return depths_[photo.view.id.index]; }
  /// Does the true camera of `photo` see the point, unhidden?
  bool sees(const TruePhoto& photo, const Eigen::Vector3d& p_world) const;

 private:
  void takePosesOf(const std::filesystem::path& run);

  std::vector<TruePhoto> photos_;
  std::vector<TrueDepth> depths_;
};

/// The photo at the smallest of JPEG's scales that keeps `megapixels`, as cf-run decodes it.
cv::Mat decoded(const TruePhoto& photo, double megapixels);

}  // namespace cf::bench
