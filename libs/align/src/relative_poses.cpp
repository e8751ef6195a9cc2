// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "relative_poses.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "cf/base/median.h"

namespace cf {
namespace {

SegmentId segmentOf(const MatchGraph& graph, FrameId id) {
  return {id.uav, graph.photo(id).segment};
}

std::vector<MatchGraph::Pair> select(const MatchGraph& graph, const PairViews& views,
                                     PairSelection selection) {
  std::map<std::pair<FrameId, SegmentId>, std::vector<std::pair<std::size_t, MatchGraph::Pair>>>
      partners;
  for (const auto& [pair, matches] : graph.pairs()) {
    const SegmentId a = segmentOf(graph, pair.first), b = segmentOf(graph, pair.second);
    if (a == b || views.count(pair.first) == 0 || views.count(pair.second) == 0) continue;
    partners[{pair.first, b}].emplace_back(matches.size(), pair);
    partners[{pair.second, a}].emplace_back(matches.size(), pair);
  }
  std::map<MatchGraph::Pair, int> choosers;
  for (auto& [key, pairs] : partners) {
    std::sort(pairs.begin(), pairs.end(), [](const auto& x, const auto& y) {
      return x.first != y.first ? x.first > y.first : x.second < y.second;
    });
    for (std::size_t i = 0; i < std::min(selection.partners, pairs.size()); ++i)
      ++choosers[pairs[i].second];
  }
  std::vector<MatchGraph::Pair> chosen;
  for (const auto& [pair, count] : choosers)
    if (count >= selection.choosers) chosen.push_back(pair);
  return chosen;
}

double translationResidual(const Eigen::Isometry3d& T_world_a, const Eigen::Isometry3d& T_world_b,
                           const Eigen::Isometry3d& T_a_b) {
  return (predictRelativePose(T_world_a, T_world_b).translation() - T_a_b.translation()).norm();
}

}  // namespace

std::vector<PairObservation> observePairs(const MatchGraph& graph, const PairViews& views,
                                          PairSelection selection, const PairOptions& options,
                                          PairObservations& known) {
  const std::vector<MatchGraph::Pair> pairs = select(graph, views, selection);
  std::vector<MatchGraph::Pair> todo;
  for (const auto& pair : pairs)
    if (known.count(pair) == 0) todo.push_back(pair);
  std::vector<std::optional<PairObservation>> found(todo.size());
  tbb::parallel_for(std::size_t{0}, todo.size(), [&](std::size_t i) {
    const auto& [a, b] = todo[i];
    auto observation = observePair(views.at(a), views.at(b), graph.pairs().at(todo[i]), options);
    if (observation) found[i] = std::move(*observation);
  });
  for (std::size_t i = 0; i < todo.size(); ++i) known[todo[i]] = std::move(found[i]);
  std::vector<PairObservation> observations;
  for (const auto& pair : pairs)
    if (const auto& observation = known.at(pair)) observations.push_back(*observation);
  return observations;
}

std::map<FrameId, double> scalesInMap(const MatchGraph& graph, const PoseTable& table,
                                      const std::vector<SparsePoint>& points) {
  std::map<FrameId, std::vector<double>> ratios;
  for (const SparsePoint& point : points)
    for (const SparseObservation& o : point.observations) {
      const double inverse =
          graph.photo(o.frame).inverse_depth[static_cast<std::size_t>(o.feature)];
      const double depth = (table.poses.at(o.frame).T_world_cam.inverse() * point.position_m).z();
      if (inverse > 0 && depth > 0) ratios[o.frame].push_back(depth * inverse);
    }
  std::map<FrameId, double> scales;
  for (auto& [id, values] : ratios) scales[id] = upperMedian(std::move(values));
  return scales;
}

RelativePose relativePoseInMap(const PairObservation& observation, const PairViews& before,
                               const PoseTable& after, double scale_a, double scale_b) {
  RelativePose pose = observation.pose;
  const PairView &a = before.at(pose.a), &b = before.at(pose.b);
  double sum = 0, weight = 0;
  for (const auto& [length, factor] : {std::pair(observation.by_depth_a, scale_a / a.scale),
                                       std::pair(observation.by_depth_b, scale_b / b.scale)}) {
    if (length.sigma_m <= 0) continue;
    const double w = 1 / std::pow(length.sigma_m * factor, 2);
    sum += w * length.length_m * factor;
    weight += w;
  }
  const double length_m = pose.T_a_b.translation().norm();
  if (weight > 0 && length_m > 0) {
    const double factor = sum / weight / length_m;
    pose.T_a_b.translation() *= factor;
    pose.sigma.head<3>() *= factor;
  }
  const bool georeferenced = a.trusted && b.trusted;
  pose.residual_before =
      georeferenced ? translationResidual(a.T_world_cam, b.T_world_cam, pose.T_a_b) : 0;
  pose.residual_after = translationResidual(after.poses.at(pose.a).T_world_cam,
                                            after.poses.at(pose.b).T_world_cam, pose.T_a_b);
  return pose;
}

}  // namespace cf
