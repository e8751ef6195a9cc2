// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace cf {

/// Local features of one photo, structure of arrays: N rows each.
struct FeatureSet {
  static constexpr int kDescriptorSize = 128;

  std::vector<Eigen::Vector2f> pixel;    ///< distorted, in pixels of the original photo
  std::vector<float> scale_px;           ///< diameter of the blob [px of the original photo]
  double pixel_size = 1;                 ///< pixels of the original photo per pixel searched
  std::vector<std::uint8_t> descriptor;  ///< N x 128, RootSIFT times 512, clamped
  std::vector<std::uint8_t> colour;      ///< N x 3, BGR at the feature

  std::size_t size() const { return pixel.size(); }
  const std::uint8_t* row(std::size_t i) const { return descriptor.data() + i * kDescriptorSize; }
};

/// Feature `a` of one photo and feature `b` of another.
struct FeatureMatch {
  int a = 0;
  int b = 0;
};

}  // namespace cf
