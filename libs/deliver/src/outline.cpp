// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "outline.h"

#include <algorithm>
#include <map>
#include <utility>

#include "cf/base/median.h"

namespace cf {
namespace {

constexpr std::size_t kFewestViews = 3;
constexpr double kFarthest = 3;  ///< from its first photo, in medians of all

std::map<FrameId, Eigen::Vector3d> centresOf(const RunRecord& run) {
  std::map<FrameId, Eigen::Vector3d> centres;
  for (std::size_t u = 0; u < run.uavs.size(); ++u)
    for (const PhotoPose& pose : run.uavs[u].final_trajectory)
      centres[{static_cast<std::uint16_t>(u), pose.photo}] = pose.T_world_cam.translation();
  return centres;
}

bool turnsLeft(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x() > 0;
}

/// Andrew's monotone chain.
std::vector<Eigen::Vector3d> hullOf(std::vector<Eigen::Vector3d> points) {
  std::sort(points.begin(), points.end(), [](const auto& a, const auto& b) {
    return std::pair(a.x(), a.y()) < std::pair(b.x(), b.y());
  });
  std::vector<Eigen::Vector3d> hull;
  const auto walk = [&](auto begin, auto end) {
    const std::size_t first = hull.size();
    for (auto p = begin; p != end; ++p) {
      while (hull.size() >= first + 2 && !turnsLeft(hull[hull.size() - 2], hull.back(), *p))
        hull.pop_back();
      hull.push_back(*p);
    }
    hull.pop_back();  // the other way begins there
  };
  if (points.size() < 3) return {};
  walk(points.begin(), points.end());
  walk(points.rbegin(), points.rend());
  return hull.size() < 3 ? std::vector<Eigen::Vector3d>() : hull;
}

}  // namespace

std::vector<Eigen::Vector3d> outlineOf(const RunRecord& run) {
  const std::map<FrameId, Eigen::Vector3d> centres = centresOf(run);
  std::vector<std::pair<double, Eigen::Vector3d>> by_distance;
  for (const SparsePoint& p : run.sparse_points) {
    if (p.observations.size() < kFewestViews) continue;
    const auto centre = centres.find(p.observations.front().frame);
    if (centre != centres.end())
      by_distance.emplace_back((p.position_m - centre->second).norm(), p.position_m);
  }
  std::vector<double> distances;
  for (const auto& [distance, p] : by_distance) distances.push_back(distance);
  const double farthest = kFarthest * upperMedian(std::move(distances));
  std::vector<Eigen::Vector3d> near;
  for (const auto& [distance, p] : by_distance)
    if (distance <= farthest) near.push_back(p);
  return hullOf(std::move(near));
}

}  // namespace cf
