// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "keyframe_of.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "cf/features/extract.h"

namespace cf {

Keyframe keyframeOf(const LocalMap& map, PhotoIndex i) {
  const TrackedPhoto& photo = map.photo(i);
  Keyframe k;
  k.id = photo.frame.id;
  k.time = photo.frame.time;
  k.name = photo.frame.name;
  k.segment = photo.segment;
  k.T_local_cam = photo.T_local_cam;
  k.camera = photo.frame.camera;
  k.attitude = photo.frame.attitude;
  k.height_above_ground_m = photo.frame.height_above_ground_m;
  k.matches = photo.matches;
  k.inverse_depth.assign(photo.landmark.size(), 0.0f);
  const Eigen::Isometry3d T_cam_local = photo.T_local_cam.inverse();
  for (std::size_t f = 0; f < photo.landmark.size(); ++f) {
    if (photo.landmark[f] < 0) continue;
    const Landmark& landmark = map.landmarks[static_cast<std::size_t>(photo.landmark[f])];
    const double depth = (T_cam_local * map.position(landmark)).z();
    if (depth <= 0) continue;
    k.inverse_depth[f] = static_cast<float>(1 / depth);
    ++k.inliers;
  }
  return k;
}

Keyframe withBestFeatures(Keyframe keyframe, const LocalMap& map, PhotoIndex i, std::size_t most) {
  const TrackedPhoto& photo = map.photo(i);
  std::vector<int> order(photo.landmark.size());
  std::iota(order.begin(), order.end(), 0);
  const auto sights = [&](int f) {
    const int id = photo.landmark[static_cast<std::size_t>(f)];
    if (id < 0) return std::size_t{0};
    const auto& all = map.landmarks[static_cast<std::size_t>(id)].observations;
    return std::min<std::size_t>(3, all.size());
  };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return sights(a) > sights(b); });
  if (order.size() > most) order.resize(most);
  std::sort(order.begin(), order.end());
  keyframe.features = std::make_shared<const FeatureSet>(subset(*photo.features, order));
  std::vector<float> inverse_depth;
  for (const int f : order) {
    inverse_depth.push_back(keyframe.inverse_depth[static_cast<std::size_t>(f)]);
    keyframe.chain.push_back(photo.chain[static_cast<std::size_t>(f)]);
  }
  keyframe.inverse_depth = std::move(inverse_depth);
  return keyframe;
}

}  // namespace cf
