// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "observation_noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "cf/base/median.h"

namespace cf {
namespace {

/// Parts of a photo that share an error.
constexpr int kColumns = 4, kRows = 3;
constexpr double kLeastSigmaPx = 0.02;

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

std::size_t octaveOf(const FeatureSet& features, int feature) {
  const double diameter =
      static_cast<double>(features.scale_px[static_cast<std::size_t>(feature)]) /
      features.pixel_size;
  const double octave = std::floor(std::log2(std::max(diameter, 1.0)));
  return std::min(ObservationNoise::kOctaves - 1, static_cast<std::size_t>(octave));
}

/// Standard deviation of one coordinate from lengths of plane errors: their median is 1.177 of it.
double sigmaOf(std::vector<double> lengths) { return upperMedian(std::move(lengths)) / 1.1774; }

}  // namespace

ObservationNoise measureNoise(const Sights& sights, const std::map<FrameId, PosedPhoto>& photos) {
  std::map<FrameId, std::array<Cell, kColumns * kRows>> cells;
  std::vector<double> lengths;
  std::array<std::vector<double>, ObservationNoise::kOctaves> octave_lengths;
  double redundancy = 0;
  for (const SparsePoint& p : sights.points) {
    for (const SparseObservation& o : p.observations) {
      const FeatureSet& features = *sights.graph->photo(o.frame).features;
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
      lengths.push_back(e.norm());
      octave_lengths[octaveOf(features, o.feature)].push_back(e.norm());
    }
    redundancy += 2 * static_cast<double>(p.observations.size()) - 3;
  }
  ObservationNoise noise;
  if (redundancy <= 0) return noise;
  const double count = static_cast<double>(lengths.size());
  const double absorbed = std::sqrt(2 * count / redundancy);  // by the points
  noise.sigma_px = absorbed * sigmaOf(std::move(lengths));
  // What an octave with few features shows counts for little against what all show.
  constexpr double kBelief = 50;
  for (std::size_t i = 0; i < ObservationNoise::kOctaves; ++i) {
    const double n = static_cast<double>(octave_lengths[i].size());
    const double own = absorbed * sigmaOf(std::move(octave_lengths[i]));
    noise.octave_sigma_px[i] =
        std::sqrt((n * own * own + kBelief * noise.sigma_px * noise.sigma_px) / (n + kBelief));
  }

  // One-way analysis of variance: a mean of n independent residuals would vary by a n-th of them.
  constexpr int kEnough = 6;
  double common = 0, total = 0, error2 = 0;
  for (const auto& [frame, parts] : cells)
    for (const Cell& cell : parts) {
      if (cell.count < kEnough) continue;
      const double n = cell.count;
      const double mean2 = (cell.sum / n).squaredNorm();
      const double within = (cell.squares - n * mean2) / (n - 1);
      common += n * (mean2 - within / n);
      total += n;
      // Of n times the squared mean of a cell: twice its mean, on two degrees of freedom.
      error2 += within * within;
    }
  // Only what is surely more than chance.
  if (total > 0)
    noise.common_variance_px2 = std::max(0.0, common - 2 * std::sqrt(error2)) / total / 2;
  return noise;
}

NoiseModel::NoiseModel(double sigma_px, double common_error_reach)
    : common_error_reach_(common_error_reach), link_sigma_px_(sigma_px), chain_sigma_px_(sigma_px) {
  octave_sigma_px_.fill(sigma_px);
}

void NoiseModel::measure(const Sights& detections, const Sights& links, const Sights& chains,
                         const std::map<FrameId, PosedPhoto>& photos, bool deflate) {
  const ObservationNoise detected = measureNoise(detections, photos);
  const ObservationNoise linked = measureNoise(links, photos);
  const ObservationNoise chained = measureNoise(chains, photos);
  // What is common shows best where there is least else.
  const double common =
      chained.sigma_px > 0 ? chained.common_variance_px2 : detected.common_variance_px2;
  double information = 0, deflated = 0;
  const auto count = [&](const Sights& sights, double sigma_px) {
    const double variance = sigma_px * sigma_px;
    information += static_cast<double>(sights.points.size()) / variance;
    deflated +=
        static_cast<double>(sights.points.size()) / (variance + common_error_reach_ * common);
  };
  if (detected.sigma_px > 0) {
    for (std::size_t i = 0; i < ObservationNoise::kOctaves; ++i)
      octave_sigma_px_[i] = std::max(kLeastSigmaPx, detected.octave_sigma_px[i]);
    count(detections, std::max(kLeastSigmaPx, detected.sigma_px));
  }
  if (linked.sigma_px > 0) {
    link_sigma_px_ = std::max(kLeastSigmaPx, linked.sigma_px);
    count(links, link_sigma_px_);
  }
  if (chained.sigma_px > 0) {
    chain_sigma_px_ = std::max(kLeastSigmaPx, chained.sigma_px);
    count(chains, chain_sigma_px_);
  }
  if (deflate && deflated > 0) deflation_ = information / deflated;
}

double NoiseModel::detection(const FeatureSet& features, int feature) const {
  return octave_sigma_px_[octaveOf(features, feature)];
}

}  // namespace cf
