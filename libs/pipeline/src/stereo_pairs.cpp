// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "stereo_pairs.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

namespace cf {

std::vector<DenseView> denseViews(const PoseTable& table) {
  std::vector<DenseView> views;
  for (const auto& [id, entry] : table.poses)
    if (entry.median_depth_m > 0)
      views.push_back({id, entry.component, entry.T_world_cam, table.cameras[id.uav],
                       entry.near_depth_m, entry.median_depth_m, entry.far_depth_m});
  return views;
}

double matchedGroundSize(const std::vector<DenseView>& views, double megapixels) {
  std::vector<double> sizes;
  for (const DenseView& v : views) {
    const double pixels = static_cast<double>(v.camera.width) * v.camera.height;
    const double reduction = std::max(1.0, std::sqrt(pixels / (megapixels * 1e6)));
    sizes.push_back(v.median_depth_m * reduction / v.camera.fx);
  }
  std::nth_element(sizes.begin(), sizes.begin() + static_cast<long>(sizes.size() / 2), sizes.end());
  return sizes[sizes.size() / 2];
}

std::vector<StereoPair> stereoPairs(const std::vector<DenseView>& views,
                                    const DensifyOptions& options) {
  std::map<FrameId, const DenseView*> by_id;
  for (const DenseView& view : views) by_id[view.id] = &view;
  std::set<std::pair<FrameId, FrameId>> chosen;
  std::vector<StereoPair> pairs;
  for (const DenseView& reference : views)
    for (const FrameId id : choosePartners(reference, views, options))
      if (chosen.insert(std::minmax(reference.id, id)).second)
        pairs.push_back({reference, *by_id.at(id)});
  return pairs;
}

}  // namespace cf
