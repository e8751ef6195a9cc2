// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "local_plane.h"

#include <Eigen/Eigenvalues>

namespace cf {

LocalPlane localPlane(const KdTree<3>& tree, const Eigen::Vector3f& query, std::size_t neighbours) {
  thread_local std::vector<std::pair<float, std::uint32_t>> found;
  tree.nearest(query, neighbours, KdTree<3>::kUnlimited, found);
  LocalPlane plane;
  if (found.size() < 3) return plane;
  for (const auto& [d2, i] : found) plane.centre += tree.points()[i].cast<double>();
  plane.centre /= static_cast<double>(found.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const auto& [d2, i] : found) {
    const Eigen::Vector3d d = tree.points()[i].cast<double>() - plane.centre;
    covariance += d * d.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(covariance);
  const Eigen::Vector3d variance = eigen.eigenvalues();  // ascending
  plane.determined = variance[1] > 1e-4 * variance[2];
  plane.normal = eigen.eigenvectors().col(0);
  if (plane.normal.z() < 0) plane.normal = -plane.normal;
  plane.roughness = variance[2] > 0 ? variance[0] / variance.sum() : 0;
  return plane;
}

}  // namespace cf
