// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "run_surface.h"
#include "surface_registration.h"

namespace cf {

/// Rasters over the ground that two runs have in common, in the grid of run A: CV_32FC1, NaN where
/// one of them did not measure.
struct HeightChange {
  double west_m = 0, north_m = 0, cell_m = 1;
  cv::Mat height;        ///< of B, in A's heights [m]; NaN only where B has none
  cv::Mat difference;    ///< B - A [m]
  cv::Mat sigma;         ///< of it [m]
  cv::Mat smooth_sigma;  ///< [m] as if there were no edges near

  /// What the sigma was made of, found on stable ground.
  struct Noise {
    double constant_m = 0;      ///< in every cell, whatever its confidence
    double per_confidence = 0;  ///< times sqrt(1 / confidence of A + 1 / confidence of B)
    double factor = 1;          ///< that brought 95 % of stable ground within 1.96 sigma
  } noise;
  /// Of the differences of cells without an edge within three NMAD of 0.
  struct Stable {
    std::size_t cells = 0;
    double share = 0;  ///< of all such cells
    double bias_m = 0, nmad_m = 0;
    double beyond_2_sigma = 0, beyond_3_sigma = 0;  ///< shares
  } stable;
  /// Spread [m] of the mean difference of squares of stable ground, by their side [m], ascending.
  struct BlockSpread {
    double side_m = 0, nmad_m = 0;
    std::size_t blocks = 0;
  };
  std::vector<BlockSpread> block_spreads;

  double area() const { return cell_m * cell_m; }
  /// Of the mean difference over a place of that size: noise that has not averaged out.
  double meanSigma(double area_m2) const;
};

/// The cells have `cell_m`. Throws RunError where the common ground would make too many of them,
/// or has too few that both measured.
HeightChange heightChange(const RunSurface& a, const RunSurface& b, const SurfaceRegistration& r,
                          double cell_m);

}  // namespace cf
