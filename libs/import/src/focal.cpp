// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/import/focal.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace cf {
namespace {

constexpr double kFullFrameDiagonal_mm = 43.2666153;  // 36 x 24 mm
constexpr double kSigma = 0.05;
constexpr double kAssumedSigma = 0.20;
constexpr double kAssumedFocal = 0.8;  // of the longer side: 64 degrees across
// Priors of the distortion: wide drone lenses stay within this.
constexpr double kK1Sigma = 0.1;
constexpr double kK2Sigma = 0.1;

bool plausible(double focal_px, int width, int height) {
  const double ratio = focal_px / std::max(width, height);
  return ratio > 0.13 && ratio < 20;
}

double fromFocalPlane(const FocalTags& tags, int width) {
  const int original = std::max(tags.original_width, width);
  constexpr double kSmallestSensor_mm = 3;
  if (!(tags.focal_plane_px_per_mm > 0) ||
      original / tags.focal_plane_px_per_mm < kSmallestSensor_mm)
    return 0;
  return tags.focal_mm * tags.focal_plane_px_per_mm * width / original;
}

double from35mm(const FocalTags& tags, int width, int height) {
  const double longer = std::max(width, height), shorter = std::min(width, height);
  constexpr double kWidestSensor = 1.6;
  const bool crop = longer > kWidestSensor * shorter;
  const double diagonal_px = crop ? longer * 5 / 4 : std::hypot(longer, shorter);
  return tags.focal_35mm / kFullFrameDiagonal_mm * diagonal_px;
}

}  // namespace

FocalEstimate focalOf(const FocalTags& tags, int width, int height) {
  const double by_plane = fromFocalPlane(tags, width);
  if (plausible(by_plane, width, height))
    return {by_plane, kSigma * by_plane,
            fmt::format("{} mm by focal plane resolution", tags.focal_mm), false};
  const double by_35mm = from35mm(tags, width, height);
  if (plausible(by_35mm, width, height))
    return {by_35mm, kSigma * by_35mm, fmt::format("35 mm equivalent of {} mm", tags.focal_35mm),
            false};
  const double assumed = kAssumedFocal * std::max(width, height);
  return {assumed, kAssumedSigma * assumed, "assumed: no focal length is tagged", true};
}

CameraModel cameraFrom(const FocalEstimate& focal, int width, int height) {
  CameraModel camera;
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = focal.focal_px;
  camera.cx = (width - 1) / 2.0;
  camera.cy = (height - 1) / 2.0;
  camera.focal_sigma = focal.sigma_px;
  camera.k1_sigma = kK1Sigma;
  camera.k2_sigma = kK2Sigma;
  return camera;
}

}  // namespace cf
