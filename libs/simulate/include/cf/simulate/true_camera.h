// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace cf {

/// The camera that really takes the simulated photos: pinhole with Brown distortion, square pixels.
/// Its own implementation, written apart from the estimator's CameraModel, so that an error in one
/// shows. Pixel (0,0) is the centre of the top-left pixel; x right, y down, z forward.
struct TrueCamera {
  int width = 0, height = 0;      ///< [px]
  double focal = 0;               ///< [px]
  double cx = 0, cy = 0;          ///< [px]
  double k1 = 0, k2 = 0, k3 = 0;  ///< radial
  double p1 = 0, p2 = 0;          ///< tangential

  /// Pixel of a point in camera coordinates, z > 0.
  Eigen::Vector2d pixelOf(const Eigen::Vector3d& p_cam) const;
  /// Direction through a pixel in camera coordinates, with z = 1. Good to 1e-9 wherever the
  /// distortion does not fold over.
  Eigen::Vector3d rayThrough(const Eigen::Vector2d& pixel) const;
};

}  // namespace cf
