// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <vector>

#include "cf/deliver/run_record.h"

namespace cf {

/// Where the final map's points project in the photos of one UAV, minus where they were seen
/// [px of the photo].
struct Reprojection {
  static constexpr int kColumns = 8, kRows = 6;

  /// What the photos' residuals have in common in one zone of the picture.
  struct Zone {
    Eigen::Vector2d middle_px = Eigen::Vector2d::Zero();
    Eigen::Vector2d mean_px = Eigen::Vector2d::Zero();
    int count = 0;
  };

  std::vector<float> errors_px;            ///< lengths
  std::map<std::uint32_t, double> rms_px;  ///< by photo
  std::vector<Zone> zones;                 ///< row by row
  double median_px = 0, p95_px = 0;
  /// Root mean square over the zones of their means, without what chance puts there: an error of
  /// the lens, which all photos share.
  double systematic_px = 0;
};

/// By UAV; empty where the run kept no pixels of its points.
std::vector<Reprojection> reprojectionsOf(const RunRecord& run);

/// Ground size of a pixel of the photos, median over the points [m]; 0 without any.
double groundPixel(const RunRecord& run);

}  // namespace cf
