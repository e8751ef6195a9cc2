// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "chain_alignment.h"

#include "cf/features/patch_alignment.h"

namespace cf {
namespace {

constexpr double kMaxShift = 1.5;  ///< of a feature, at the feature size [px]

double greyPerPixel(const TrackedPhoto& photo) {
  return static_cast<double>(photo.grey.cols) / photo.frame.camera.width;
}

Eigen::Vector2d inGrey(const TrackedPhoto& photo, std::size_t feature) {
  return scaledPixel(photo.features->pixel[feature].cast<double>(), greyPerPixel(photo));
}

Eigen::Matrix2d warpOf(const TrackedPhoto& source, const TrackedPhoto& target,
                       const Eigen::Vector3d& p_local) {
  return patchWarp(target.T_local_cam.inverse() * source.T_local_cam,
                   source.T_local_cam.inverse() * p_local);
}

/// A sight of the landmark whose grey values are at hand and that lies in its chain, the earliest.
const LandmarkObservation* reference(const LocalMap& map, int id, PhotoIndex but) {
  const Landmark& landmark = map.landmarks[static_cast<std::size_t>(id)];
  for (const LandmarkObservation& o : landmark.observations) {
    const TrackedPhoto& photo = map.photo(o.photo);
    const bool first = &o == &landmark.observations.front();
    if (o.photo != but && !photo.grey.empty() &&
        (first || photo.chain[static_cast<std::size_t>(o.feature)] == id))
      return &o;
  }
  return nullptr;
}

}  // namespace

void alignToLandmarks(LocalMap& map, PhotoIndex photo) {
  TrackedPhoto& target = map.photo(photo);
  const double max_shift = kMaxShift * target.features->pixel_size * greyPerPixel(target);
  for (std::size_t f = 0; f < target.landmark.size(); ++f) {
    const int id = target.landmark[f];
    if (id < 0 || target.chain[f] >= 0) continue;
    const Landmark& landmark = map.landmarks[static_cast<std::size_t>(id)];
    const LandmarkObservation& first = landmark.observations.front();
    const LandmarkObservation* seen = reference(map, id, photo);
    if (first.photo == photo || seen == nullptr) continue;
    const TrackedPhoto& source = map.photo(seen->photo);
    const auto aligned = alignPatch(
        source.grey, inGrey(source, static_cast<std::size_t>(seen->feature)), target.grey,
        inGrey(target, f), warpOf(source, target, map.position(landmark)), max_shift);
    if (!aligned) continue;
    const Eigen::Vector2d pixel = scaledPixel(aligned->position, 1 / greyPerPixel(target));
    target.features->pixel[f] = pixel.cast<float>();
    target.normalized[f] = target.frame.camera.undistort(pixel);
    target.chain[f] = id;
    map.photo(first.photo).chain[static_cast<std::size_t>(first.feature)] = id;
  }
}

}  // namespace cf
