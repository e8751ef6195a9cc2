// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "ortho_ground.h"

#include <algorithm>
#include <cmath>

namespace cf {
namespace {

/// A sight that passes so far under the surface [nodes] is free, or hidden.
constexpr float kFreeBelow = 1, kHiddenBelow = 3;

}  // namespace

OrthoGround::OrthoGround(const OrthoScene& scene, const cv::Rect& nodes, bool sights)
    : scene_(scene),
      nodes_(nodes),
      reach_(sights ? kSightReach : 0),
      node_m_(scene.surface.node()),
      window_(scene.surface.window({nodes.x - reach_, nodes.y - reach_, nodes.width + 2 * reach_,
                                    nodes.height + 2 * reach_})),
      place_z_(height(nodes.width / 2, nodes.height / 2)) {
  const Eigen::Vector3d place(scene.surface.left() + (nodes.x + nodes.width / 2 + 0.5) * node_m_,
                              scene.surface.top() - (nodes.y + nodes.height / 2 + 0.5) * node_m_,
                              static_cast<double>(place_z_));
  T_world_local_ = T_world_local(scene.grid, place);
}

PhotoProjection OrthoGround::projection(int photo) const {
  const auto i = static_cast<std::size_t>(photo);
  return {scene_.photos[i], scene_.sight_limits[i], T_world_local_};
}

float OrthoGround::free(const PhotoProjection& view, const Eigen::Vector3d& place, int x, int y,
                        float top) const {
  const Eigen::Vector3d sight = (view.centre() - place) / node_m_;  // [nodes]
  const auto distance = static_cast<float>(sight.head<2>().norm());
  if (distance < 1) return 1;
  const auto node_m = static_cast<float>(node_m_);
  const float z = height(x, y), climb = static_cast<float>(sight.z()) * node_m / distance;
  const float dx = static_cast<float>(sight.x()) / distance;
  const float dy = static_cast<float>(-sight.y()) / distance;
  const float end =
      std::min({static_cast<float>(kSightReach - 1), distance, (top - z) / climb + 1});
  const float hidden = -kHiddenBelow * node_m;
  float clearance = 0;
  float u = static_cast<float>(x + reach_) + 0.5F + 2 * dx;
  float v = static_cast<float>(y + reach_) + 0.5F + 2 * dy;
  float ray = z + 2 * climb;
  for (float t = 2; t < end; t += 1, u += dx, v += dy, ray += climb) {
    clearance = std::min(clearance,
                         ray - window_.heights.at<float>(static_cast<int>(v), static_cast<int>(u)));
    if (clearance < hidden) return 0;
  }
  return std::min(1.F, (clearance / node_m + kHiddenBelow) / (kHiddenBelow - kFreeBelow));
}

}  // namespace cf
