// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "guided_search.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "cf/base/median.h"

namespace cf {
namespace {

constexpr std::size_t kFewestLandmarks = 10;
constexpr double kTail = 0.02;  ///< share of the landmarks that may lie above the range, or below

/// Inverse depth over the photo. That of a plane is an affine function of the normalized
/// coordinates; relief, houses and trees depart from it, by `low` to `high`.
struct DepthRange {
  Eigen::Vector3d plane;  ///< inverse depth = plane . (u, v, 1)
  double low = 0, high = 0;

  double at(const Eigen::Vector2d& normalized) const { return plane.dot(normalized.homogeneous()); }
};

std::optional<DepthRange> depthRangeOf(const TrackedPhoto& photo,
                                       const std::vector<double>& inverse_depth) {
  std::vector<std::size_t> known;
  for (std::size_t f = 0; f < inverse_depth.size(); ++f)
    if (inverse_depth[f] > 0) known.push_back(f);
  if (known.size() < kFewestLandmarks) return std::nullopt;
  DepthRange range;
  std::vector<double> weight(known.size(), 1.0), departure(known.size());
  for (int round = 0; round < 4; ++round) {
    Eigen::Matrix3d N = Eigen::Matrix3d::Zero();
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < known.size(); ++k) {
      const Eigen::Vector3d row = photo.normalized[known[k]].homogeneous();
      N += weight[k] * row * row.transpose();
      g += weight[k] * inverse_depth[known[k]] * row;
    }
    range.plane = N.ldlt().solve(g);
    if (!range.plane.allFinite()) return std::nullopt;
    for (std::size_t k = 0; k < known.size(); ++k)
      departure[k] = inverse_depth[known[k]] - range.at(photo.normalized[known[k]]);
    std::vector<double> size;
    for (const double d : departure) size.push_back(std::abs(d));
    const double usual = std::max(1e-12, 2 * upperMedian(std::move(size)));
    for (std::size_t k = 0; k < known.size(); ++k)
      weight[k] = 1 / (1 + departure[k] * departure[k] / (usual * usual));
  }
  std::sort(departure.begin(), departure.end());
  const auto tail = static_cast<std::size_t>(kTail * static_cast<double>(departure.size()));
  range.low = departure[tail];
  range.high = departure[departure.size() - 1 - tail];
  return range;
}

}  // namespace

std::vector<SearchDisc> searchDiscs(const LocalMap& map, PhotoIndex from, PhotoIndex to,
                                    double margin) {
  const TrackedPhoto& photo = map.photo(from);
  std::vector<double> known(photo.landmark.size(), 0.0);
  const Eigen::Isometry3d T_from_local = photo.T_local_cam.inverse();
  for (std::size_t f = 0; f < known.size(); ++f) {
    if (photo.landmark[f] < 0) continue;
    const Landmark& landmark = map.landmarks[static_cast<std::size_t>(photo.landmark[f])];
    const double depth = (T_from_local * map.position(landmark)).z();
    if (depth > 0) known[f] = 1 / depth;
  }
  std::vector<SearchDisc> discs(known.size());
  const auto range = depthRangeOf(photo, known);
  if (!range) return discs;
  const Eigen::Isometry3d T_to_from = map.photo(to).T_local_cam.inverse() * photo.T_local_cam;
  for (std::size_t f = 0; f < known.size(); ++f) {
    const double middle = known[f] > 0 ? known[f] : range->at(photo.normalized[f]);
    const double near = known[f] > 0 ? middle : middle + range->high;
    const double far = known[f] > 0 ? middle : std::max(0.0, middle + range->low);
    const Eigen::Vector3d ray = T_to_from.linear() * photo.normalized[f].homogeneous();
    const Eigen::Vector3d p_near = ray + near * T_to_from.translation();
    const Eigen::Vector3d p_far = ray + far * T_to_from.translation();
    // Closer to the camera's own plane than that is outside of any photo.
    if (p_near.z() < 0.1 || p_far.z() < 0.1) continue;
    const Eigen::Vector2d a = p_near.hnormalized(), b = p_far.hnormalized();
    discs[f] = {(a + b) / 2, (a - b).norm() / 2 + margin};
  }
  return discs;
}

}  // namespace cf
