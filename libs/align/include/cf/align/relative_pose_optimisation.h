// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <vector>

#include "cf/align/pair_observation.h"
#include "cf/base/options.h"
#include "cf/types/keyframe.h"
#include "cf/types/sim3.h"

namespace cf {

/// How relative poses move the segments of all UAVs onto each other (`method = homography`).
struct RelativePoseOptions {
  /// Sigma of the constant GNSS error of one UAV; under `method = homography` the keys
  /// `bias_sigma_horizontal_m` and `bias_sigma_vertical_m`, which the joint adjustment shares.
  double bias_horizontal_m = 3, bias_vertical_m = 10;
  double rotation_prior_deg = 10;  ///< sigma of a georeferenced segment's attitude
  double scale_prior = 0.2;        ///< relative sigma of its scale, the fixes apart
  double loss = 3;                 ///< whitened residual at which an observation loses weight

  void visit(OptionVisitor& v);
};

/// A segment as georeferenced by its UAV alone, and its fixes.
struct SegmentInput {
  GeoSegment segment;
  std::vector<std::optional<GnssPosition>> fixes;  ///< per pose of the segment, or empty
};

/// What moves a segment: p_world = S_world_before * p_before.
struct SegmentCorrection {
  SegmentId id;
  Sim3 S_world_before;
  bool connected = false;  ///< an observation joins it to another segment; else it stays as it was
  int component = 0;       ///< joined segments share one; 0 holds the central UAV's main segment
};

/// Observation against poses: metres of translation, radians of rotation.
struct ObservationResidual {
  double before_m = 0, after_m = 0;
  double before_rad = 0, after_rad = 0;
  double weight = 0;  ///< 1 = full, towards 0 = outlier; 0 for a pair within one segment
};

struct RelativePoseSolution {
  std::vector<SegmentCorrection> corrections;       ///< as the segments were given
  std::vector<ObservationResidual> residuals;       ///< as the observations were given
  std::map<std::uint16_t, Eigen::Vector3d> bias_m;  ///< GNSS minus map, by UAV; central UAV zero
};

/// One similarity per segment from the observations between segments, residuals (9): e_q compares
/// body-frame rotations, e_t the direction of the translation and, apart from it, its length by the
/// depths of either photo. Those lengths move with the scale of the segment that measured them, so
/// that the relative scale is observed. Fixes hold each segment through one unknown bias per UAV;
/// the largest georeferenced segment of `central_uav` is held fixed. Robust by a Cauchy loss that
/// tightens from solve to solve. A segment without georeference enters through its observations.
/// Throws std::invalid_argument where an observation names a photo that no segment has.
/// Deterministic.
RelativePoseSolution optimiseRelativePoses(const std::vector<SegmentInput>& segments,
                                           const std::vector<PairObservation>& observations,
                                           std::uint16_t central_uav,
                                           const RelativePoseOptions& options);

}  // namespace cf
