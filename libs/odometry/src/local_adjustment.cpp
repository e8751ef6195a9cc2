// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "local_adjustment.h"

#include <algorithm>
#include <map>
#include <set>

#include "cf/geometry/triangulation.h"
#include "inverse_depth_solver.h"

namespace cf {
namespace {

constexpr double kHuber = 0.5;  ///< beyond it a residual counts linearly [threshold]

void removeOutliers(LocalMap& map, const std::vector<int>& landmark_ids, double threshold) {
  for (const int id : landmark_ids) {
    Landmark& landmark = map.landmarks[static_cast<std::size_t>(id)];
    const Eigen::Vector3d p = map.position(landmark);
    auto& all = landmark.observations;
    const auto bad = [&](const LandmarkObservation& o) {
      TrackedPhoto& photo = map.photo(o.photo);
      const auto feature = static_cast<std::size_t>(o.feature);
      if (landmark.inverse_depth > 0 &&
          reprojectionError({photo.T_local_cam, photo.normalized[feature]}, p) < threshold)
        return false;
      photo.landmark[feature] = -1;
      return true;
    };
    // The anchor's own error is zero by construction: without support it goes as well.
    all.erase(std::remove_if(all.begin() + 1, all.end(), bad), all.end());
    if (all.size() >= 2 && landmark.inverse_depth > 0) continue;
    for (const auto& o : all) map.photo(o.photo).landmark[static_cast<std::size_t>(o.feature)] = -1;
    all.resize(1);
    landmark.inverse_depth = 0;
  }
}

}  // namespace

void adjustLocally(LocalMap& map, const std::vector<PhotoIndex>& window, double threshold) {
  std::set<int> seen;
  for (const PhotoIndex i : window)
    for (const int id : map.photo(i).landmark)
      if (id >= 0) seen.insert(id);
  const std::vector<int> landmark_ids(seen.begin(), seen.end());
  std::map<PhotoIndex, int> pose_of;
  for (const int id : landmark_ids)
    for (const auto& o : map.landmarks[static_cast<std::size_t>(id)].observations)
      pose_of.emplace(o.photo, 0);
  if (pose_of.empty()) return;

  std::vector<AdjustedPose> poses;
  int held = 0;
  for (auto& [i, pose] : pose_of) {
    const TrackedPhoto& photo = map.photo(i);
    pose = static_cast<int>(poses.size());
    const bool in_window = std::find(window.begin(), window.end(), i) != window.end();
    poses.push_back({photo.T_local_cam.linear(), photo.T_local_cam.translation(),
                     photo.final || !in_window, false});
    held += poses.back().held;
  }
  // A young segment has no two held poses yet: its first photo stays at the origin of the local
  // frame and the first baseline keeps its length.
  if (held == 0) poses.front().held = true;
  if (held <= 1) {
    const auto first_free =
        std::find_if(poses.begin(), poses.end(), [](const auto& p) { return !p.held; });
    if (first_free != poses.end()) first_free->length_held = first_free->t.norm() > 1e-6;
  }
  std::vector<AdjustedPoint> points;
  for (const int id : landmark_ids) {
    const Landmark& landmark = map.landmarks[static_cast<std::size_t>(id)];
    const auto normalized = [&](const LandmarkObservation& o) {
      return map.photo(o.photo).normalized[static_cast<std::size_t>(o.feature)];
    };
    const LandmarkObservation& anchor = landmark.observations.front();
    AdjustedPoint& point = points.emplace_back();
    point.anchor = pose_of.at(anchor.photo);
    point.anchor_normalized = normalized(anchor);
    point.inverse_depth = landmark.inverse_depth;
    for (std::size_t o = 1; o < landmark.observations.size(); ++o)
      point.sightings.push_back(
          {pose_of.at(landmark.observations[o].photo), normalized(landmark.observations[o])});
  }
  if (!solveInverseDepths(poses, points, kHuber * threshold)) return;

  for (const auto& [i, pose] : pose_of) {
    const AdjustedPose& adjusted = poses[static_cast<std::size_t>(pose)];
    if (adjusted.held) continue;
    map.photo(i).T_local_cam.linear() = adjusted.R;
    map.photo(i).T_local_cam.translation() = adjusted.t;
  }
  for (std::size_t k = 0; k < points.size(); ++k)
    map.landmarks[static_cast<std::size_t>(landmark_ids[k])].inverse_depth =
        points[k].inverse_depth;
  removeOutliers(map, landmark_ids, threshold);
}

}  // namespace cf
