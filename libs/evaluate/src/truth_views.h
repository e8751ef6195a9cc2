// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "run_inputs.h"

namespace cf {

/// Depth along the optical axis [m] of every `step`-th pixel of a photo: value (column i, row j)
/// belongs to pixel (i * step, j * step); 0 = nothing.
struct SparseDepth {
  int step = 1;
  cv::Mat values;  ///< CV_32FC1

  /// Bilinear; 0 beside the grid, where a neighbour is 0, and where they differ by more than 2 %.
  double at(const Eigen::Vector2d& pixel) const;
};

/// Throws RunError where the file has no STEP.
SparseDepth readSparseDepth(const std::filesystem::path& file);

/// A photo of the truth with its depths, thinned.
struct TruthView {
  std::size_t uav = 0, photo = 0;  ///< indices into RunInputs
  Eigen::Isometry3d T_cam_world = Eigen::Isometry3d::Identity();
  const CameraModel* camera = nullptr;  ///< the true one
  bool mapped = false;  ///< the truth has its depth map; otherwise the depths are made of dsm.tif
  SparseDepth depth;

  /// The pixel at which the true camera sees the point; false if it is out of sight, hidden, or its
  /// surroundings are no smooth surface.
  bool sees(const Eigen::Vector3d& p_world, Eigen::Vector2d& pixel) const;
};

/// depth/<uav>/<photo>.tif below `folder`.
std::filesystem::path depthFile(const std::filesystem::path& folder, const RunUav& uav,
                                const RunPhoto& photo);

/// All photos of the truth with a camera and a depth map, or at least a dsm.tif to make one of, by
/// UAV and photo; `run` must outlive them.
std::vector<TruthView> readTruthViews(const RunInputs& run);

}  // namespace cf
