// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "observation_noise.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cf {
namespace {

/// Parts of a photo that share an error.
constexpr int kColumns = 4, kRows = 3;

struct Cell {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double squares = 0;
  int count = 0;
};

int cellOf(const CameraModel& camera, const Eigen::Vector2d& pixel) {
  const int x = static_cast<int>(pixel.x() * kColumns / camera.width);
  const int y = static_cast<int>(pixel.y() * kRows / camera.height);
  return std::clamp(y, 0, kRows - 1) * kColumns + std::clamp(x, 0, kColumns - 1);
}

}  // namespace

ObservationNoise measureNoise(const MatchGraph& graph, const std::vector<SparsePoint>& points,
                              const std::map<FrameId, PosedPhoto>& photos) {
  std::map<FrameId, std::array<Cell, kColumns * kRows>> cells;
  double squares = 0, redundancy = 0;
  for (const SparsePoint& p : points) {
    for (const SparseObservation& o : p.observations) {
      const FeatureSet& features = *graph.photo(o.frame).features;
      const PosedPhoto& photo = photos.at(o.frame);
      const Eigen::Vector2d pixel =
          features.pixel[static_cast<std::size_t>(o.feature)].cast<double>();
      const Eigen::Vector2d e =
          (photo.camera.project(photo.T_world_cam.inverse() * p.position_m) - pixel) /
          features.pixel_size;
      Cell& cell = cells[o.frame][static_cast<std::size_t>(cellOf(photo.camera, pixel))];
      cell.sum += e;
      cell.squares += e.squaredNorm();
      ++cell.count;
      squares += e.squaredNorm();
    }
    redundancy += 2 * static_cast<double>(p.observations.size()) - 3;
  }
  // One-way analysis of variance: a mean of n independent residuals would vary by a n-th of them.
  constexpr int kEnough = 6;
  double common = 0, total = 0;
  for (const auto& [frame, parts] : cells)
    for (const Cell& cell : parts) {
      if (cell.count < kEnough) continue;
      const double n = cell.count;
      const double mean2 = (cell.sum / n).squaredNorm();
      const double within = (cell.squares - n * mean2) / (n - 1);
      common += n * (mean2 - within / n);
      total += cell.squares;
    }
  ObservationNoise noise;
  if (redundancy > 0) noise.sigma_px = std::sqrt(squares / redundancy);
  if (total > 0) noise.common_share = std::max(0.0, common / total);
  return noise;
}

}  // namespace cf
