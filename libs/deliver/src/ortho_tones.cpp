// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "ortho_tones.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace cf {
namespace {

constexpr int kThumbnailWidth_px = 128;
constexpr int kRounds = 5;
constexpr double kNoise = 0.1;        ///< of a difference of logarithms, beyond it counts less
constexpr double kGainSigma = 0.3;    ///< prior
constexpr double kPriorNoise = 0.3;   ///< of a difference, where the prior is concerned
constexpr std::size_t kCompared = 6;  ///< photos of a cell
constexpr std::size_t kDifferencesPerPhoto = 150;
constexpr float kDark = 8, kBright = 247;
constexpr float kFloor = 4;  ///< added before logarithms: dark places have little to say

struct Sample {
  cv::Vec3f log_tone;
  float r2 = 0;
  bool usable = false;
};

/// Bilinear; `u`, `v` in pixels of the original photo.
cv::Vec3f lookUp(const OrthoPhoto& photo, float u, float v) {
  const cv::Mat& image = photo.thumbnail;
  const auto to = [](float p, int from, int size) {
    const float x = (p + 0.5F) * static_cast<float>(size) / static_cast<float>(from) - 0.5F;
    return std::clamp(x, 0.F, static_cast<float>(size) - 1.001F);
  };
  const float x = to(u, photo.camera.width, image.cols), y = to(v, photo.camera.height, image.rows);
  const int i = static_cast<int>(x), j = static_cast<int>(y);
  const float a = x - static_cast<float>(i), b = y - static_cast<float>(j);
  const auto at = [&](int row, int column) { return cv::Vec3f(image.at<cv::Vec3b>(row, column)); };
  return (at(j, i) * (1 - a) + at(j, i + 1) * a) * (1 - b) +
         (at(j + 1, i) * (1 - a) + at(j + 1, i + 1) * a) * b;
}

cv::Vec3f logOf(const cv::Vec3f& tone) {
  return {std::log(tone[0] + kFloor), std::log(tone[1] + kFloor), std::log(tone[2] + kFloor)};
}

/// Squared distance from the middle of the photo, 1 at its corners.
float radius2(const CameraModel& camera, float u, float v) {
  const float x = 2 * u / static_cast<float>(camera.width) - 1;
  const float y = 2 * v / static_cast<float>(camera.height) - 1;
  return 0.5F * (x * x + y * y);
}

Sample sample(const OrthoPhoto& photo, const OrthoCandidate& candidate) {
  const cv::Vec3f tone = lookUp(photo, candidate.u, candidate.v);
  Sample out;
  out.log_tone = logOf(tone);
  out.r2 = radius2(photo.camera, candidate.u, candidate.v);
  out.usable = *std::min_element(tone.val, tone.val + 3) > kDark &&
               *std::max_element(tone.val, tone.val + 3) < kBright && out.r2 < 1;
  return out;
}

}  // namespace

cv::Mat orthoThumbnail(const cv::Mat& photo) {
  if (photo.empty()) return {};
  const int width = std::min(kThumbnailWidth_px, photo.cols);
  const int height = std::max(2, width * photo.rows / photo.cols);
  cv::Mat small, smooth;
  cv::resize(photo, small, {width, height}, 0, 0, cv::INTER_AREA);
  cv::GaussianBlur(small, smooth, {0, 0}, 1);
  return smooth;
}

OrthoTones::OrthoTones(const std::vector<std::vector<OrthoCandidate>>& candidates,
                       const std::vector<OrthoPhoto>& photos)
    : photos_(photos), gains_(photos.size(), cv::Vec3f::all(0)) {
  solve(candidates);
}

cv::Vec3f OrthoTones::shown(int photo, float u, float v) const {
  return logOf(lookUp(photos_[static_cast<std::size_t>(photo)], u, v));
}

cv::Vec3f OrthoTones::corrected(int photo, float u, float v) const {
  const auto i = static_cast<std::size_t>(photo);
  const std::size_t lens = 2 * static_cast<std::size_t>(photos_[i].lens);
  const float r2 = radius2(photos_[i].camera, u, v);
  return shown(photo, u, v) + gains_[i] + r2 * falloff_[lens] + r2 * r2 * falloff_[lens + 1];
}

void OrthoTones::solve(const std::vector<std::vector<OrthoCandidate>>& candidates) {
  int lenses = 0;
  for (const OrthoPhoto& photo : photos_) lenses = std::max(lenses, photo.lens + 1);
  const int n = static_cast<int>(photos_.size());
  falloff_.assign(2 * static_cast<std::size_t>(lenses), cv::Vec3f::all(0));

  struct Difference {
    int a = 0, b = 0;
    Sample at_a, at_b;
  };
  std::vector<Difference> differences;
  for (const auto& cell : candidates) {
    if (cell.size() < 2) continue;
    const Sample first = sample(photos_[static_cast<std::size_t>(cell[0].photo)], cell[0]);
    if (!first.usable) continue;
    for (std::size_t k = 1; k < std::min(cell.size(), kCompared); ++k) {
      const Sample other = sample(photos_[static_cast<std::size_t>(cell[k].photo)], cell[k]);
      if (other.usable) differences.push_back({cell[0].photo, cell[k].photo, first, other});
    }
  }

  if (differences.empty()) return;

  // An even part of them is enough.
  const std::size_t step = 1 + differences.size() / (kDifferencesPerPhoto * photos_.size());
  for (std::size_t i = 0; i * step < differences.size(); ++i)
    differences[i] = differences[i * step];
  differences.resize((differences.size() + step - 1) / step);

  using Triplets = std::vector<Eigen::Triplet<double>>;
  const int unknowns = n + 2 * lenses;
  for (int channel = 0; channel < 3; ++channel) {
    Eigen::VectorXd x = Eigen::VectorXd::Zero(unknowns);
    for (int round = 0; round < kRounds; ++round) {
      Triplets triplets;
      Eigen::VectorXd right = Eigen::VectorXd::Zero(unknowns);
      for (int i = 0; i < unknowns; ++i)
        triplets.emplace_back(i, i, std::pow(kPriorNoise / kGainSigma, 2));
      for (const Difference& d : differences) {
        const int lens_a = n + 2 * photos_[static_cast<std::size_t>(d.a)].lens;
        const int lens_b = n + 2 * photos_[static_cast<std::size_t>(d.b)].lens;
        const double ra = static_cast<double>(d.at_a.r2), rb = static_cast<double>(d.at_b.r2);
        const std::pair<int, double> row[] = {{d.a, 1},      {d.b, -1},
                                              {lens_a, ra},  {lens_a + 1, ra * ra},
                                              {lens_b, -rb}, {lens_b + 1, -rb * rb}};
        const double wanted =
            static_cast<double>(d.at_b.log_tone[channel] - d.at_a.log_tone[channel]);
        double residual = -wanted;
        for (const auto& [i, v] : row) residual += v * x[i];
        const double w = 1 / (1 + std::pow(residual / kNoise, 2));
        for (const auto& [i, v] : row) {
          right[i] += w * v * wanted;
          for (const auto& [j, u] : row) triplets.emplace_back(i, j, w * v * u);
        }
      }
      Eigen::SparseMatrix<double> normal(unknowns, unknowns);
      normal.setFromTriplets(triplets.begin(), triplets.end());
      x = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(normal).solve(right);
    }
    for (std::size_t i = 0; i < gains_.size(); ++i)
      gains_[i][channel] = static_cast<float>(x[static_cast<int>(i)]);
    for (std::size_t i = 0; i < falloff_.size(); ++i)
      falloff_[i][channel] = static_cast<float>(x[n + static_cast<int>(i)]);
  }
}

}  // namespace cf
