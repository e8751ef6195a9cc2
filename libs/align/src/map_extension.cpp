// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "map_extension.h"

#include <algorithm>
#include <cstddef>
#include <set>
#include <utility>

#include "cf/base/median.h"
#include "relative_poses.h"

namespace cf {
namespace {

/// Adjusted beside the fresh photos, and held around them, for each fresh one.
constexpr std::size_t kFreePartners = 1, kHeldPartners = 2;

/// The newest photo of a segment up to `id` that is in the map.
std::optional<FrameId> anchorOf(const MatchGraph& graph, const GrowingMap& map, FrameId id,
                                int segment) {
  for (auto at = map.scales.upper_bound(id); at != map.scales.begin();) {
    --at;
    if (at->first.uav != id.uav) break;
    if (graph.photo(at->first).segment == segment) return at->first;
  }
  return std::nullopt;
}

/// Photos of the map that match the given ones, best first; all of one component.
std::vector<FrameId> partnersOf(const MatchGraph& graph, const std::set<FrameId>& of, int component,
                                const GrowingMap& map) {
  std::map<FrameId, std::size_t> matches;
  for (const auto& [pair, shared] : graph.pairs())
    for (const auto& [one, other] : {pair, std::pair(pair.second, pair.first)})
      if (of.count(one) > 0 && of.count(other) == 0 && map.scales.count(other) > 0 &&
          map.table.poses.at(other).component == component)
        matches[other] += shared.size();
  std::vector<std::pair<std::size_t, FrameId>> order;
  for (const auto& [id, count] : matches) order.emplace_back(count, id);
  std::stable_sort(order.begin(), order.end(),
                   [](const auto& x, const auto& y) { return x.first > y.first; });
  std::vector<FrameId> partners;
  for (const auto& [count, id] : order) partners.push_back(id);
  return partners;
}

/// Adjusts the photos of one component that were carried, with those around them.
void adjustWindow(const MatchGraph& graph, const std::set<FrameId>& carried, int component,
                  const JointOptions& options, GrowingMap& map) {
  const std::vector<FrameId> partners = partnersOf(graph, carried, component, map);
  std::set<FrameId> photos = carried;
  JointProblem problem;
  problem.cameras = map.table.cameras;
  problem.cameras_held = problem.draft = true;
  std::vector<double> depths;
  const auto add = [&](FrameId id, bool held) {
    photos.insert(id);
    problem.photos.push_back({id, map.table.poses.at(id).T_world_cam, {}, held});
    depths.push_back(map.table.poses.at(id).median_depth_m);
  };
  for (const FrameId id : carried) add(id, false);
  const std::size_t free = kFreePartners * carried.size();
  const std::size_t all = std::min(partners.size(), free + kHeldPartners * carried.size());
  for (std::size_t i = 0; i < all; ++i) add(partners[i], i >= free);
  std::sort(problem.photos.begin(), problem.photos.end(),
            [](const JointPhoto& a, const JointPhoto& b) { return a.id < b.id; });
  problem.median_depth_m = upperMedian(std::move(depths));
  if (problem.photos.size() < 2 || !(problem.median_depth_m > 0)) return;

  const JointSolution solution = adjustJointly(graph, buildTracks(graph, photos), problem, options);
  for (const JointPhoto& photo : problem.photos)
    if (!photo.held) map.table.poses.at(photo.id).T_world_cam = solution.T_world_cam.at(photo.id);
  // Depths and scales of the fresh ones: those of the others were measured with more points.
  std::vector<SparsePoint> points = solution.points;
  for (SparsePoint& point : points) {
    auto& o = point.observations;
    o.erase(std::remove_if(o.begin(), o.end(),
                           [&](const auto& x) { return carried.count(x.frame) == 0; }),
            o.end());
  }
  setDepths(points, map.table);
  for (const auto& [id, scale] : scalesInMap(graph, map.table, points)) map.scales[id] = scale;
}

}  // namespace

std::optional<Sim3> similarityInMap(const MatchGraph& graph, const GrowingMap& map, FrameId id,
                                    int segment) {
  const auto anchor = anchorOf(graph, map, id, segment);
  if (!anchor) return std::nullopt;
  return similarityAt(map.scales.at(*anchor), map.table.poses.at(*anchor).T_world_cam,
                      graph.photo(*anchor).T_local_cam);
}

std::vector<FrameId> carryOn(const MatchGraph& graph, const std::vector<FrameId>& fresh,
                             GrowingMap& map) {
  std::vector<FrameId> carried;
  for (const FrameId id : fresh) {
    const int segment = graph.photo(id).segment;
    const auto anchor = anchorOf(graph, map, id, segment);
    if (!anchor) continue;
    const Sim3 S_world_local = *similarityInMap(graph, map, *anchor, segment);
    PoseTable::Entry entry = map.table.poses.at(*anchor);
    entry.covariance = {};
    entry.T_world_cam = S_world_local.carry(graph.photo(id).T_local_cam);
    map.table.poses[id] = entry;
    map.scales[id] = S_world_local.scale;
    carried.push_back(id);
  }
  return carried;
}

void adjustAround(const MatchGraph& graph, const std::vector<FrameId>& carried,
                  const JointOptions& options, GrowingMap& map) {
  std::map<int, std::set<FrameId>> by_component;
  for (const FrameId id : carried) by_component[map.table.poses.at(id).component].insert(id);
  for (const auto& [component, photos] : by_component)
    adjustWindow(graph, photos, component, options, map);
}

void setDepths(const std::vector<SparsePoint>& points, PoseTable& table) {
  std::map<FrameId, std::vector<double>> depths;
  for (const SparsePoint& point : points)
    for (const SparseObservation& o : point.observations)
      depths[o.frame].push_back(
          (table.poses.at(o.frame).T_world_cam.inverse() * point.position_m).z());
  for (auto& [id, of_photo] : depths) {
    std::sort(of_photo.begin(), of_photo.end());
    const auto at = [&, &sorted = of_photo](double share) {
      return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
    };
    PoseTable::Entry& entry = table.poses.at(id);
    entry.near_depth_m = at(0.05);
    entry.median_depth_m = at(0.5);
    entry.far_depth_m = at(0.95);
  }
}

}  // namespace cf
