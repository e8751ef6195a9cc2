// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "segment_pose.h"

#include <limits>
#include <set>

#include "cf/geometry/pnp.h"
#include "cf/geometry/triangulation.h"
#include "ground_scale.h"
#include "keyframe_of.h"
#include "photo_pose.h"

namespace cf {
namespace {

constexpr int kFewestForScale = 5;  ///< landmarks that give a baseline its length
/// How uncertain a resection may leave the photo's corners, in inlier thresholds: beyond the first
/// two-view geometry is preferred, beyond the second it is no pose.
constexpr double kCertain = 1, kMostStray = 3;
constexpr double kSightSigmas = 3;  ///< of a landmark's sight in the inlier threshold
/// Photos that share no landmark are far apart [rad].
constexpr double kLeastParallaxOverGround = 0.2;

/// Where the photo sees landmarks of the segment; of photos that see the same, the most recent
/// counts: it sees it most alike.
std::vector<LandmarkSight> sightsOf(const LocalMap& map, int segment, const TrackedPhoto& target,
                                    const MatchesByPhoto& matches) {
  std::vector<LandmarkSight> seen;
  std::set<int> used;
  for (auto it = matches.rbegin(); it != matches.rend(); ++it) {
    const TrackedPhoto& other = map.photo(it->first);
    if (other.segment != segment) continue;
    for (const FeatureMatch& m : it->second) {
      const int id = other.landmark[static_cast<std::size_t>(m.a)];
      if (id < 0 || !used.insert(m.b).second) continue;
      seen.push_back({map.position(map.landmarks[static_cast<std::size_t>(id)]),
                      target.normalized[static_cast<std::size_t>(m.b)]});
    }
  }
  return seen;
}

std::optional<Eigen::Isometry3d> poseByTwoView(const LocalMap& map, int segment,
                                               const TrackedPhoto& target,
                                               const MatchesByPhoto& matches,
                                               const std::vector<LandmarkSight>& seen,
                                               const PoseLimits& limits) {
  if (static_cast<int>(seen.size()) < kFewestForScale) return std::nullopt;
  PhotoIndex other = -1;
  for (const auto& [i, all] : matches)
    if (map.photo(i).segment == segment && (other < 0 || all.size() >= matches.at(other).size()))
      other = i;
  const TrackedPhoto& posed = map.photo(other);
  const auto view = twoViewOf(posed, target, matches.at(other), limits);
  if (!view) return std::nullopt;
  const auto pose =
      poseByScaledTwoView(posed.T_local_cam, view->T_a_b, seen, limits.threshold, kFewestForScale);
  if (!pose) return std::nullopt;
  return *pose;
}

}  // namespace

Result<TwoView> twoViewOf(const TrackedPhoto& a, const TrackedPhoto& b,
                          const std::vector<FeatureMatch>& matches, const PoseLimits& limits) {
  std::vector<Eigen::Vector2d> in_a, in_b;
  for (const FeatureMatch& m : matches) {
    in_a.push_back(a.normalized[static_cast<std::size_t>(m.a)]);
    in_b.push_back(b.normalized[static_cast<std::size_t>(m.b)]);
  }
  TwoViewOptions options;
  options.threshold = limits.threshold / 2;  // a point of two sights splits the error between them
  options.min_inliers = limits.min_inliers;
  return estimateTwoView(in_a, in_b, options);
}

std::optional<Eigen::Isometry3d> poseInSegment(const LocalMap& map, int segment,
                                               const TrackedPhoto& target,
                                               const MatchesByPhoto& matches,
                                               const PoseLimits& limits) {
  const std::vector<LandmarkSight> seen = sightsOf(map, segment, target, matches);
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector2d> sights;
  for (const LandmarkSight& s : seen) {
    points.push_back(s.p_local);
    sights.push_back(s.normalized);
  }
  const auto resected = resect(points, sights, {limits.threshold, limits.min_inliers});
  double stray = std::numeric_limits<double>::infinity();
  if (resected) {
    std::vector<LandmarkSight> inliers;
    for (std::size_t i = 0; i < seen.size(); ++i)
      if (resected->inlier[i]) inliers.push_back(seen[i]);
    const CameraModel& camera = target.frame.camera;
    const Eigen::Vector2d corner(camera.width / (2 * camera.fx), camera.height / (2 * camera.fy));
    stray = strayAtCorners(resected->T_world_cam, inliers, corner, limits.threshold / kSightSigmas);
  }
  std::optional<Eigen::Isometry3d> T_local_cam;
  if (stray > kCertain * limits.threshold)
    T_local_cam = poseByTwoView(map, segment, target, matches, seen, limits);
  if (!T_local_cam && stray < kMostStray * limits.threshold) T_local_cam = resected->T_world_cam;
  return T_local_cam;
}

std::optional<Eigen::Isometry3d> poseOverGround(const LocalMap& map, PhotoIndex last,
                                                const TrackedPhoto& target,
                                                const std::vector<FeatureMatch>& matches,
                                                const PoseLimits& limits) {
  const TrackedPhoto& posed = map.photo(last);
  const auto view = twoViewOf(posed, target, matches, limits);
  if (!view || view->median_parallax_rad < kLeastParallaxOverGround) return std::nullopt;
  std::vector<GroundSight> known, measured;
  const std::vector<float> inverse_depth = keyframeOf(map, last).inverse_depth;
  for (std::size_t f = 0; f < inverse_depth.size(); ++f)
    if (inverse_depth[f] > 0)
      known.push_back({posed.normalized[f], static_cast<double>(inverse_depth[f])});
  for (std::size_t k = 0; k < matches.size(); ++k) {
    if (!view->inlier[k]) continue;
    const Eigen::Vector2d& here = posed.normalized[static_cast<std::size_t>(matches[k].a)];
    const auto point =
        triangulate({{Eigen::Isometry3d::Identity(), here},
                     {view->T_a_b, target.normalized[static_cast<std::size_t>(matches[k].b)]}});
    if (point && point->max_error < limits.threshold)
      measured.push_back({here, 1 / point->position.z()});
  }
  const auto scale = scaleByGround(known, measured);
  if (!scale) return std::nullopt;
  Eigen::Isometry3d T_last_cam = view->T_a_b;
  T_last_cam.translation() *= *scale;
  return posed.T_local_cam * T_last_cam;
}

}  // namespace cf
