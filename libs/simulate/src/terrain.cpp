// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "terrain.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "random_stream.h"

namespace cf {
namespace {

/// Sum of plane waves of random direction, 60 m to 400 m long: smooth hills without a lattice.
class Hills {
 public:
  explicit Hills(std::uint64_t seed) {
    RandomStream random(seed);
    for (auto& w : waves_) {
      const double length = 60 * std::pow(400.0 / 60, random.uniform());
      const double angle = 2 * M_PI * random.uniform();
      w.k = 2 * M_PI / length * Eigen::Vector2d(std::cos(angle), std::sin(angle));
      w.phase = 2 * M_PI * random.uniform();
      w.amplitude = length;
    }
  }
  double operator()(const Eigen::Vector2d& p) const {
    double sum = 0;
    for (const auto& w : waves_) sum += w.amplitude * std::sin(w.k.dot(p) + w.phase);
    return sum;
  }

 private:
  struct Wave {
    Eigen::Vector2d k;
    double phase = 0, amplitude = 0;
  };
  std::array<Wave, 12> waves_;
};

}  // namespace

Terrain::Terrain(bool hills, double relief_m, const Eigen::Vector2d& half_extent_m,
                 std::uint64_t seed) {
  // A flat ground needs few triangles; hills at most a few million.
  cell_ = hills ? std::max(2.0, half_extent_m.maxCoeff() / 500) : 50;
  columns_ = 2 * static_cast<int>(std::ceil(half_extent_m.x() / cell_)) + 1;
  rows_ = 2 * static_cast<int>(std::ceil(half_extent_m.y() / cell_)) + 1;
  corner_ = -cell_ / 2 * Eigen::Vector2d(columns_ - 1, rows_ - 1);
  heights_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), 0.0F);
  if (!hills) return;
  const Hills shape(seed);
  std::vector<double> raw;
  raw.reserve(heights_.size());
  for (int r = 0; r < rows_; ++r) {
    for (int c = 0; c < columns_; ++c) {
      raw.push_back(shape(corner_ + cell_ * Eigen::Vector2d(c, r)));
    }
  }
  const auto [low, high] = std::minmax_element(raw.begin(), raw.end());
  const double scale = relief_m / std::max(*high - *low, 1e-9);
  for (std::size_t i = 0; i < raw.size(); ++i) {
    heights_[i] = static_cast<float>((raw[i] - *low) * scale);
  }
}

Eigen::Vector3f Terrain::vertex(int column, int row) const {
  return {static_cast<float>(corner_.x() + cell_ * column),
          static_cast<float>(corner_.y() + cell_ * row), at(column, row)};
}

std::vector<std::uint32_t> Terrain::triangles() const {
  std::vector<std::uint32_t> corners;
  corners.reserve(heights_.size() * 6);
  const auto width = static_cast<std::uint32_t>(columns_);
  for (std::uint32_t r = 0; r + 1 < static_cast<std::uint32_t>(rows_); ++r) {
    for (std::uint32_t c = 0; c + 1 < width; ++c) {
      const std::uint32_t sw = r * width + c, nw = sw + width;
      corners.insert(corners.end(), {sw, sw + 1, nw + 1, sw, nw + 1, nw});
    }
  }
  return corners;
}

double Terrain::height(double x, double y) const {
  const double u = std::clamp((x - corner_.x()) / cell_, 0.0, columns_ - 1.0);
  const double v = std::clamp((y - corner_.y()) / cell_, 0.0, rows_ - 1.0);
  const int c = std::min(static_cast<int>(u), columns_ - 2);
  const int r = std::min(static_cast<int>(v), rows_ - 2);
  const double fu = u - c, fv = v - r;
  const double sw = at(c, r), se = at(c + 1, r), nw = at(c, r + 1), ne = at(c + 1, r + 1);
  return fu > fv ? sw + fu * (se - sw) + fv * (ne - se) : sw + fu * (ne - nw) + fv * (nw - sw);
}

Eigen::Vector3f Terrain::normal(float x, float y) const {
  const double u = std::clamp((static_cast<double>(x) - corner_.x()) / cell_, 1.0, columns_ - 2.0);
  const double v = std::clamp((static_cast<double>(y) - corner_.y()) / cell_, 1.0, rows_ - 2.0);
  if (columns_ < 4 || rows_ < 4) return Eigen::Vector3f::UnitZ();
  const int c = std::min(static_cast<int>(u), columns_ - 3);
  const int r = std::min(static_cast<int>(v), rows_ - 3);
  const auto fu = static_cast<float>(u - c), fv = static_cast<float>(v - r);
  auto slope = [&](int dc, int dr) {
    return Eigen::Vector2f(at(c + dc - 1, r + dr) - at(c + dc + 1, r + dr),
                           at(c + dc, r + dr - 1) - at(c + dc, r + dr + 1));
  };
  const Eigen::Vector2f s = (1 - fv) * ((1 - fu) * slope(0, 0) + fu * slope(1, 0)) +
                            fv * ((1 - fu) * slope(0, 1) + fu * slope(1, 1));
  return Eigen::Vector3f(s.x(), s.y(), static_cast<float>(2 * cell_)).normalized();
}

}  // namespace cf
