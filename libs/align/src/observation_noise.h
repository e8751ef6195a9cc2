// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <map>
#include <vector>

#include "cf/align/match_graph.h"
#include "cf/types/pose_table.h"
#include "track_triangulation.h"

namespace cf {

/// How far features lie from where the map projects.
struct ObservationNoise {
  static constexpr std::size_t kOctaves = 8;
  /// Of one coordinate, at the feature size, from the median so that gross errors do not count.
  double sigma_px = 0;
  /// The same by the octave of the blob's diameter: the middle of a large blob is known less well.
  std::array<double, kOctaves> octave_sigma_px = {};
  /// Variance of one coordinate that the features of a part of a photo have in common [px^2]. A
  /// perfect camera model leaves none; rolling shutter, in-camera lens correction and moving
  /// leaves leave 0.02 to 0.05 of the variance of a detection on ordinary drones.
  double common_variance_px2 = 0;
};

/// Points and where their observations are.
struct Sights {
  const MatchGraph* graph = nullptr;
  std::vector<SparsePoint> points;
};

/// Measured from the residuals of all observations of the points; tracks pay for the three
/// coordinates of their point. Zeros without redundant observations.
ObservationNoise measureNoise(const Sights& sights, const std::map<FrameId, PosedPhoto>& photos);

/// What observations are worth in an adjustment.
class NoiseModel {
 public:
  /// All the same until measured. `common_error_reach`: see JointOptions.
  NoiseModel(double sigma_px, double common_error_reach);

  /// From points of detections, one of each chain, of links that were aligned (link_alignment.h),
  /// and of chains (track_parts.h). `deflate` once the map follows the chains: before, its own
  /// error would count as common.
  void measure(const Sights& detections, const Sights& links, const Sights& chains,
               const std::map<FrameId, PosedPhoto>& photos, bool deflate);

  double detection(const FeatureSet& features, int feature) const;  ///< sigma, feature size [px]
  double linked() const { return link_sigma_px_; }                  ///< sigma, feature size [px]
  double chained() const { return chain_sigma_px_; }                ///< sigma, feature size [px]
  /// By how much the variance of every observation is larger than what it shows, so that what they
  /// have in common does not outvote priors and GNSS by sheer number.
  double deflation() const { return deflation_; }

 private:
  double common_error_reach_;
  std::array<double, ObservationNoise::kOctaves> octave_sigma_px_ = {};
  double link_sigma_px_, chain_sigma_px_;
  double deflation_ = 1;
};

}  // namespace cf
