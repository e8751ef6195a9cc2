// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

#include "cf/simulate/photographer.h"
#include "scene_samples.h"

namespace cf {

/// Where the camera is at a moment counted from the middle of the photo.
Eigen::Isometry3d poseAt(const CameraMotion& motion, double time_s);
/// When a row is read.
double timeOfRow(const TrueCamera& camera, const PhotoOptions& options, double row);

/// A square of a photo with a margin of kApron pixels, whose light is gathered together.
class PhotoTile {
 public:
  static constexpr int kSize = 64;  ///< [px] without the apron
  static constexpr int kApron = 2;
  static constexpr int kSide = kSize + 2 * kApron;

  PhotoTile();
  /// Linear light of the tile whose first pixel (without apron) is (x0, y0), mean of `moments`
  /// instants spread over the exposure.
  void render(const Scene& scene, const TrueCamera& camera, const CameraMotion& motion,
              const PhotoOptions& options, int x0, int y0, int moments);
  /// BGR of pixel (x0 + x, y0 + y).
  std::array<float, 3> light(int x, int y) const;

 private:
  void castRays(const Scene& scene, const TrueCamera& camera, const CameraMotion& motion,
                const PhotoOptions& options, int x0, int y0, double moment_s);
  void refineEdges(const Scene& scene, const TrueCamera& camera, int samples_per_pixel);
  void blur(const TrueCamera& camera, const CameraMotion& motion, double exposure_s);

  Samples pixels_, extra_;
  std::vector<int> edges_;
  std::vector<float> light_, blurred_, sum_;
};

}  // namespace cf
