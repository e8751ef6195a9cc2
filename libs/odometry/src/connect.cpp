// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "connect.h"

#include <algorithm>

#include "cf/geometry/triangulation.h"

namespace cf {
namespace {

/// A new landmark needs this angle between its rays [rad]; less says nothing about depth.
constexpr double kMinTriangulationAngle = 0.015;

}  // namespace

void connect(LocalMap& map, PhotoIndex i, PhotoIndex j, const std::vector<FeatureMatch>& matches,
             double threshold) {
  TrackedPhoto& pi = map.photo(i);
  TrackedPhoto& pj = map.photo(j);
  for (const FeatureMatch& m : matches) {
    int& li = pi.landmark[static_cast<std::size_t>(m.a)];
    int& lj = pj.landmark[static_cast<std::size_t>(m.b)];
    if (li >= 0 && lj >= 0) continue;
    const Sight si{pi.T_local_cam, pi.normalized[static_cast<std::size_t>(m.a)]};
    const Sight sj{pj.T_local_cam, pj.normalized[static_cast<std::size_t>(m.b)]};
    if (li < 0 && lj < 0) {
      const auto point = triangulate({si, sj});
      if (!point || point->max_error > threshold || point->max_angle_rad < kMinTriangulationAngle)
        continue;
      li = lj = static_cast<int>(map.landmarks.size());
      const double depth = (pi.T_local_cam.inverse() * point->position).z();
      map.landmarks.push_back({1 / depth, {{i, m.a}, {j, m.b}}});
      continue;
    }
    const int id = std::max(li, lj);
    Landmark& landmark = map.landmarks[static_cast<std::size_t>(id)];
    const bool extend_j = lj < 0;
    if (reprojectionError(extend_j ? sj : si, map.position(landmark)) > threshold) continue;
    const LandmarkObservation added =
        extend_j ? LandmarkObservation{j, m.b} : LandmarkObservation{i, m.a};
    auto& all = landmark.observations;
    if (std::any_of(all.begin(), all.end(), [&](const auto& o) { return o.photo == added.photo; }))
      continue;
    all.push_back(added);
    (extend_j ? lj : li) = id;
  }
}

}  // namespace cf
