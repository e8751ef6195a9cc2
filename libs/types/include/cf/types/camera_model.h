// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <tuple>

namespace cf {

/// Pinhole camera with Brown distortion. Pixel (0,0) is the centre of the top-left pixel.
/// Camera frame: x right, y down, z forward. Distortion order and sign are OpenCV's plumb bob.
struct CameraModel {
  int width = 0;                          ///< [px] of the original photo
  int height = 0;                         ///< [px]
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< [px]
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;

  double focal_sigma = 0;     ///< standard deviation of fx [px]; 0 = held fixed
  double k1_sigma = 0;        ///< 0 = held fixed
  double k2_sigma = 0;        ///< 0 = held fixed
  std::uint32_t version = 0;  ///< counts the refinements; 0 = as given

  /// Camera-frame point (z > 0) to distorted pixel.
  Eigen::Vector2d project(const Eigen::Vector3d& p_cam) const;
  /// Point of the normalized plane z = 1 to distorted pixel.
  Eigen::Vector2d distort(const Eigen::Vector2d& normalized) const;
  /// Distorted pixel to the normalized plane z = 1; Newton's method, error below 1e-9 wherever the
  /// distortion does not fold over.
  Eigen::Vector2d undistort(const Eigen::Vector2d& pixel) const;
  /// The same camera for the photo resized to new_width x new_height.
  CameraModel scaled(int new_width, int new_height) const;
  friend bool operator==(const CameraModel& a, const CameraModel& b) {
    const auto all = [](const CameraModel& c) {
      return std::tie(c.width, c.height, c.fx, c.fy, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2, c.k3,
                      c.focal_sigma, c.k1_sigma, c.k2_sigma, c.version);
    };
    return all(a) == all(b);
  }
  bool contains(const Eigen::Vector2d& pixel) const {
    return pixel.x() >= -0.5 && pixel.y() >= -0.5 && pixel.x() < width - 0.5 &&
           pixel.y() < height - 0.5;
  }
};

}  // namespace cf
