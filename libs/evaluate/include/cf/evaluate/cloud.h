// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cf/evaluate/registration.h"

namespace cf {

/// Two clouds in one frame, relative to one origin near both, so that float suffices.
struct CloudPair {
  std::vector<Eigen::Vector3f> estimate;
  std::vector<Eigen::Vector3f> reference;
  bool common_world = false;  ///< both origins were known and the estimate brought to the reference
};

/// Reads two PLY files, or folders: OUTDIR with cloud/cloud.ply, REFDIR with cloud.ply. A
/// world.json in the file's folder or the one above it gives its ENU origin; if only one is known,
/// or none, the two are taken to be the same. Points that are not finite are dropped.
CloudPair readClouds(const std::filesystem::path& estimate, const std::filesystem::path& reference);

inline constexpr std::array<double, 5> kDistanceLimits_m = {0.1, 0.25, 0.5, 1.0, 2.0};

/// Of distances of estimated points to the reference [m].
struct DistanceFigures {
  double median_m = 0, rms_m = 0, nmad_m = 0, p95_m = 0;
  std::array<double, 5> share_within = {};  ///< of kDistanceLimits_m
};

struct CloudEvaluation {
  bool common_world = false;  ///< as in CloudPair
  std::uint64_t estimate_points = 0, reference_points = 0;
  std::uint64_t sampled = 0;   ///< estimated points looked at: every n-th of a large cloud
  std::uint64_t compared = 0;  ///< of them with a reference point within 0.5 m horizontally
  /// To the least-squares plane of the 10 nearest reference points (unsigned; the NMAD is of the
  /// signed distances), and to the nearest reference point.
  DistanceFigures plane, nearest;
  double plane_bias_m = 0;  ///< median of the signed plane distances, above is positive
  /// Shares of the reference points with an estimated point within 0.5 m and 1 m.
  double completeness_050 = 0, completeness_100 = 0;
  std::optional<Registration> icp;
};

/// Compares the estimate with the reference, moved onto it first if `icp`. Throws RunError where a
/// cloud is empty, nothing can be compared or the clouds cannot be registered.
CloudEvaluation evaluateCloud(CloudPair clouds, bool icp);

/// One JSON object; with `gsd_m`, the distances also in units of it.
std::string toJson(const CloudEvaluation& evaluation, std::optional<double> gsd_m);

}  // namespace cf
