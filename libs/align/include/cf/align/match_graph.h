// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "cf/align/candidates.h"
#include "cf/types/keyframe.h"
#include "cf/types/pose_table.h"

namespace cf {

struct MatchGraphOptions {
  double ratio = 0.85;      ///< Lowe's ratio
  double threshold_px = 3;  ///< epipolar or homography distance at the feature size [px]
  int min_inliers = 20;     ///< below, a pair is not connected
};

/// The photos at the centre and the verified feature matches of pairs of them. Pairs are matched
/// once, side by side; the result does not depend on the number of threads.
class MatchGraph {
 public:
  using Pair = std::pair<FrameId, FrameId>;  ///< first < second

  explicit MatchGraph(const MatchGraphOptions& options) : options_(options) {}

  void add(std::shared_ptr<const Keyframe> keyframe);
  /// Matches those of `pairs` that have not been tried yet. Whether any became connected.
  bool match(const std::vector<Pair>& pairs);
  /// Takes over what a copy has matched since.
  void learn(const MatchGraph& copy);

  const std::map<FrameId, std::shared_ptr<const Keyframe>>& photos() const { return photos_; }
  const Keyframe& photo(FrameId id) const { return *photos_.at(id); }
  /// Connected pairs only; matches with a in the first photo.
  const std::map<Pair, std::vector<FeatureMatch>>& pairs() const { return pairs_; }
  /// Inlier distance on the normalized plane for a photo: pixels at the feature size.
  double threshold(FrameId id) const { return thresholds_.at(id); }

 private:
  MatchGraphOptions options_;
  std::map<FrameId, std::shared_ptr<const Keyframe>> photos_;
  std::map<FrameId, std::vector<Eigen::Vector2d>> normalized_;
  std::map<FrameId, double> thresholds_;
  std::map<Pair, std::vector<FeatureMatch>> pairs_;
  std::set<Pair> tried_;
};

/// One ground point as seen by several photos: at most one feature of each.
using Track = std::vector<SparseObservation>;

/// Connected features; a component that holds two features of one photo is cut back to the
/// photos that it holds once. In a fixed order.
std::vector<Track> buildTracks(const MatchGraph& graph);
/// The same among some of the photos, as if there were no others.
std::vector<Track> buildTracks(const MatchGraph& graph, const std::set<FrameId>& photos);

}  // namespace cf
