// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "track_triangulation.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "cf/geometry/triangulation.h"

namespace cf {
namespace {

constexpr double kMinAngle = 0.01;  ///< between rays, for a depth worth having [rad]

SparsePoint pointOf(const MatchGraph& graph, Track track, const Eigen::Vector3d& position) {
  SparsePoint point;
  point.position_m = position;
  const SparseObservation& first = track.front();
  const std::uint8_t* bgr = graph.photo(first.frame).features->colour.data() + 3 * first.feature;
  std::copy(bgr, bgr + 3, point.bgr);
  point.observations = std::move(track);
  return point;
}

std::optional<SparsePoint> triangulateTrack(const MatchGraph& graph, const Track& track,
                                            const std::map<FrameId, PosedPhoto>& photos,
                                            double threshold_px) {
  Track kept;
  std::vector<Sight> sights;
  std::vector<double> limits;
  for (const SparseObservation& o : track) {
    const auto photo = photos.find(o.frame);
    if (photo == photos.end()) continue;
    const CameraModel& camera = photo->second.camera;
    const FeatureSet& features = *graph.photo(o.frame).features;
    kept.push_back(o);
    sights.push_back(
        {photo->second.T_world_cam,
         camera.undistort(features.pixel[static_cast<std::size_t>(o.feature)].cast<double>())});
    limits.push_back(threshold_px * features.pixel_size / camera.fx);
  }
  // The worst sight goes until all agree.
  while (sights.size() >= 2) {
    const auto point = triangulate(sights);
    if (!point && sights.size() == 2) break;
    std::size_t worst = 0;
    double worst_ratio = 0;
    for (std::size_t i = 0; point && i < sights.size(); ++i) {
      const double ratio = reprojectionError(sights[i], point->position) / limits[i];
      if (ratio > worst_ratio) {
        worst_ratio = ratio;
        worst = i;
      }
    }
    if (point && worst_ratio < 1) {
      if (point->max_angle_rad <= kMinAngle) break;
      return pointOf(graph, std::move(kept), point->position);
    }
    const auto at = static_cast<std::ptrdiff_t>(worst);
    sights.erase(sights.begin() + at);
    limits.erase(limits.begin() + at);
    kept.erase(kept.begin() + at);
  }
  return std::nullopt;
}

}  // namespace

std::vector<SparsePoint> triangulateTracks(const MatchGraph& graph,
                                           const std::vector<Track>& tracks,
                                           const std::map<FrameId, PosedPhoto>& photos,
                                           double threshold_px) {
  std::vector<std::optional<SparsePoint>> found(tracks.size());
  tbb::parallel_for(std::size_t{0}, tracks.size(), [&](std::size_t i) {
    found[i] = triangulateTrack(graph, tracks[i], photos, threshold_px);
  });
  std::vector<SparsePoint> points;
  for (auto& point : found)
    if (point) points.push_back(std::move(*point));
  return points;
}

double reprojectionRmsPx(const MatchGraph& graph, const std::vector<SparsePoint>& points,
                         const std::map<FrameId, PosedPhoto>& photos) {
  double sum = 0;
  std::size_t count = 0;
  for (const SparsePoint& p : points)
    for (const SparseObservation& o : p.observations) {
      const FeatureSet& features = *graph.photo(o.frame).features;
      const PosedPhoto& photo = photos.at(o.frame);
      const Eigen::Vector2d e = photo.camera.project(photo.T_world_cam.inverse() * p.position_m) -
                                features.pixel[static_cast<std::size_t>(o.feature)].cast<double>();
      sum += e.squaredNorm() / (features.pixel_size * features.pixel_size);
      ++count;
    }
  return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0;
}

}  // namespace cf
