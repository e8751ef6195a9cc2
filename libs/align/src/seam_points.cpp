// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "seam_points.h"

#include <tbb/parallel_for.h>

#include <iterator>
#include <utility>

#include "cf/geometry/triangulation.h"

namespace cf {
namespace {

/// Between rays of one UAV: below, the height that it sees by itself is too uncertain [rad].
constexpr double kMinAngle = 0.06;
/// Sights of one UAV that disagree by more show different points [px at the feature size].
constexpr double kWithinUavPx = 3;

struct SightsOfUav {
  std::vector<Sight> sights;
  double limit = 0;  ///< of their error on the normalized plane
};

std::vector<SeamPoint> ofTrack(const MatchGraph& graph, const Track& track,
                               const std::map<FrameId, PosedPhoto>& photos) {
  std::map<std::uint16_t, SightsOfUav> by_uav;
  for (const SparseObservation& o : track) {
    const auto photo = photos.find(o.frame);
    if (photo == photos.end()) continue;
    const FeatureSet& features = *graph.photo(o.frame).features;
    const CameraModel& camera = photo->second.camera;
    SightsOfUav& own = by_uav[o.frame.uav];
    own.sights.push_back(
        {photo->second.T_world_cam,
         camera.undistort(features.pixel[static_cast<std::size_t>(o.feature)].cast<double>())});
    own.limit = kWithinUavPx * features.pixel_size / camera.fx;
  }
  std::map<std::uint16_t, Eigen::Vector3d> seen;
  if (by_uav.size() > 1)
    for (const auto& [uav, own] : by_uav) {
      if (own.sights.size() < 2) continue;
      const auto point = triangulate(own.sights);
      if (point && point->max_angle_rad > kMinAngle && point->max_error < own.limit)
        seen[uav] = point->position;
    }
  std::vector<SeamPoint> points;
  for (auto a = seen.begin(); a != seen.end(); ++a)
    for (auto b = std::next(a); b != seen.end(); ++b)
      points.push_back({a->first, b->first, (a->second + b->second) / 2,
                        Eigen::Vector3d(b->second - a->second)});
  return points;
}

}  // namespace

std::vector<SeamPoint> seamPoints(const MatchGraph& graph, const std::vector<Track>& tracks,
                                  const std::map<FrameId, PosedPhoto>& photos) {
  std::vector<std::vector<SeamPoint>> found(tracks.size());
  tbb::parallel_for(std::size_t{0}, tracks.size(),
                    [&](std::size_t i) { found[i] = ofTrack(graph, tracks[i], photos); });
  std::vector<SeamPoint> points;
  for (const auto& of_track : found) points.insert(points.end(), of_track.begin(), of_track.end());
  return points;
}

}  // namespace cf
