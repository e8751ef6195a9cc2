// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/core/mat.hpp>

#include "cf/geometry/rectification.h"

namespace cf::support {

/// Ground at height 0 with one flat-roofed house on it, all textured; the exact surface is known.
struct HouseScene {
  double roof_m = 8, half_width_m = 7;  // the house stands about the origin
  double fine_wavelength_m = 0.35;      // of the texture

  /// Height of the surface over a place.
  double height(double x, double y) const {
    return std::abs(x) <= half_width_m && std::abs(y) <= half_width_m ? roof_m : 0;
  }
  /// Distance to the nearest wall seen from above, negative on the roof.
  double distanceToWall(double x, double y) const {
    const double dx = std::abs(x) - half_width_m, dy = std::abs(y) - half_width_m;
    if (dx <= 0 && dy <= 0) return std::max(dx, dy);
    return std::hypot(std::max(dx, 0.0), std::max(dy, 0.0));
  }
  /// First hit of a ray from above.
  Eigen::Vector3d hit(const Eigen::Vector3d& origin, const Eigen::Vector3d& ray) const {
    const Eigen::Array3d low(-half_width_m, -half_width_m, 0);
    const Eigen::Array3d high(half_width_m, half_width_m, roof_m);
    const Eigen::Array3d a = (low - origin.array()) / ray.array();
    const Eigen::Array3d b = (high - origin.array()) / ray.array();
    const double enter = a.min(b).maxCoeff(), leave = a.max(b).minCoeff();
    const double t = enter <= leave && enter > 0 ? enter : -origin.z() / ray.z();
    return origin + t * ray;
  }
  double grey(const Eigen::Vector3d& p) const {
    double sum = 0, total = 0;
    for (int octave = 0; octave < 4; ++octave) {
      const double wave = fine_wavelength_m * (1 << (2 * octave));
      const double weight = 1 + 0.4 * octave;
      sum += weight * noise(p.x() / wave + 13.7 * p.z(), p.y() / wave + 7.1 * p.z(), octave);
      total += weight;
    }
    return 30 + 200 * sum / total;
  }

 private:
  static double lattice(int i, int j, int octave) {
    auto h = static_cast<std::uint32_t>(i) * 0x8da6b343U ^
             static_cast<std::uint32_t>(j) * 0xd8163841U ^
             static_cast<std::uint32_t>(octave) * 0xcb1ab31fU;
    h = (h ^ (h >> 15)) * 0x2c1b3c6dU;
    h = (h ^ (h >> 12)) * 0x297a2d39U;
    return static_cast<double>(h ^ (h >> 15)) / std::numeric_limits<std::uint32_t>::max();
  }
  static double noise(double x, double y, int octave) {
    const double fx = std::floor(x), fy = std::floor(y);
    const auto smooth = [](double t) { return t * t * (3 - 2 * t); };
    const double s = smooth(x - fx), t = smooth(y - fy);
    const int i = static_cast<int>(fx), j = static_cast<int>(fy);
    return (1 - t) * ((1 - s) * lattice(i, j, octave) + s * lattice(i + 1, j, octave)) +
           t * ((1 - s) * lattice(i, j + 1, octave) + s * lattice(i + 1, j + 1, octave));
  }
};

/// The photo of a camera, with its lens distortion. `gain` and `offset` mimic another exposure.
inline cv::Mat photograph(const HouseScene& scene, const PosedCamera& camera, double gain = 1,
                          double offset = 0) {
  cv::Mat image(camera.camera.height, camera.camera.width, CV_8UC3);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      const Eigen::Vector2d n = camera.camera.undistort({u, v});
      const Eigen::Vector3d ray = camera.T_world_cam.linear() * Eigen::Vector3d(n.x(), n.y(), 1);
      const double g = scene.grey(scene.hit(camera.T_world_cam.translation(), ray));
      const auto value = static_cast<std::uint8_t>(std::clamp(gain * g + offset + 0.5, 0.0, 255.0));
      std::fill_n(image.ptr<std::uint8_t>(v) + 3 * u, 3, value);
    }
  }
  return image;
}

/// A camera that looks down from (x, y, z), its top towards north turned by yaw, tilted by pitch
/// and roll [rad].
inline PosedCamera cameraAt(const CameraModel& model, double x, double y, double z, double yaw = 0,
                            double pitch = 0, double roll = 0) {
  Eigen::Matrix3d down;
  down << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  PosedCamera camera;
  camera.camera = model;
  camera.T_world_cam.translation() << x, y, z;
  camera.T_world_cam.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * down *
                                Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitX()) *
                                Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitY());
  return camera;
}

/// 640 x 480 with a noticeable distortion and an off-centre principal point.
inline CameraModel distortedCamera() {
  CameraModel camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 520;
  camera.cx = 325.3;
  camera.cy = 233.8;
  camera.k1 = -0.11;
  camera.k2 = 0.03;
  camera.p1 = 8e-4;
  camera.p2 = -5e-4;
  return camera;
}

}  // namespace cf::support
