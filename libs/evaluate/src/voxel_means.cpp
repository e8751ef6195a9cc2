// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "voxel_means.h"

#include <tbb/parallel_sort.h>

#include <cstdint>
#include <utility>

namespace cf {

std::vector<Eigen::Vector3f> voxelMeans(const std::vector<Eigen::Vector3f>& points,
                                        const Eigen::AlignedBox3f& box, double voxel_m) {
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keyed;
  keyed.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!box.contains(points[i])) continue;
    std::uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double offset = points[i][axis] - box.min()[axis];
      key = (key << 21) | static_cast<std::uint64_t>(offset / voxel_m);
    }
    keyed.emplace_back(key, static_cast<std::uint32_t>(i));
  }
  tbb::parallel_sort(keyed.begin(), keyed.end());
  std::vector<Eigen::Vector3f> means;
  for (std::size_t i = 0; i < keyed.size();) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    const std::size_t first = i;
    for (; i < keyed.size() && keyed[i].first == keyed[first].first; ++i)
      sum += points[keyed[i].second].cast<double>();
    means.push_back((sum / static_cast<double>(i - first)).cast<float>());
  }
  return means;
}

std::vector<Eigen::Vector3f> everyNth(const std::vector<Eigen::Vector3f>& points,
                                      std::size_t limit) {
  const std::size_t n = (points.size() + limit - 1) / limit;
  if (n <= 1) return points;
  std::vector<Eigen::Vector3f> kept;
  kept.reserve(points.size() / n + 1);
  for (std::size_t i = 0; i < points.size(); i += n) kept.push_back(points[i]);
  return kept;
}

}  // namespace cf
