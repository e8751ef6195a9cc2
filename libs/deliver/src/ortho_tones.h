// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "cf/deliver/orthophoto.h"
#include "ortho_views.h"

namespace cf {

/// A gain for each photo and a fall-off a r^2 + b r^4 to the corners for each lens, per channel and
/// in logarithms, by robust least squares over what neighbouring photos show of the same cells of
/// the lattice.
class OrthoTones {
 public:
  OrthoTones(const std::vector<std::vector<OrthoCandidate>>& candidates,
             const std::vector<OrthoPhoto>& photos);

  /// Logarithms of the photo's colour (BGR) around a pixel of the original, as it is.
  cv::Vec3f shown(int photo, float u, float v) const;
  /// The same with gain and fall-off.
  cv::Vec3f corrected(int photo, float u, float v) const;

  const std::vector<cv::Vec3f>& gains() const { return gains_; }  ///< logarithms, by photo

 private:
  void solve(const std::vector<std::vector<OrthoCandidate>>& candidates);

  const std::vector<OrthoPhoto>& photos_;
  std::vector<cv::Vec3f> gains_;
  std::vector<cv::Vec3f> falloff_;  ///< a and b of each lens, one after the other
};

}  // namespace cf
