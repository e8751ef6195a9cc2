// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "extrema.h"

#include <cmath>
#include <cstdint>
#include <optional>

namespace cf::sift {
namespace {

constexpr int kBorder = 5;           ///< no extrema so close to the border [px]
constexpr int kMoves = 5;            ///< that the quadratic fit may take to a better pixel
constexpr float kEdgeRatio = 10.0f;  ///< greatest ratio of principal curvatures

CF_CLONES void subtract(const float* a, const float* b, int count, float* out) {
  for (int x = 0; x < count; ++x) out[x] = a[x] - b[x];
}

CF_CLONES void leastOf(const float* a, const float* b, const float* c, int count, float* out) {
  for (int x = 0; x < count; ++x) {
    const float ab = a[x] < b[x] ? a[x] : b[x];
    out[x] = ab < c[x] ? ab : c[x];
  }
}

CF_CLONES void greatestOf(const float* a, const float* b, const float* c, int count, float* out) {
  for (int x = 0; x < count; ++x) {
    const float ab = a[x] > b[x] ? a[x] : b[x];
    out[x] = ab > c[x] ? ab : c[x];
  }
}

/// Not 0 where |d| exceeds the threshold and is beyond no neighbour's range.
CF_CLONES void markExtrema(const float* d, const float* low, const float* high, float threshold,
                           int begin, int end, std::int32_t* mark) {
  for (int x = begin; x < end; ++x) {
    const std::int32_t top =
        (d[x] > threshold) & (d[x] >= high[x - 1]) & (d[x] >= high[x]) & (d[x] >= high[x + 1]);
    const std::int32_t bottom =
        (d[x] < -threshold) & (d[x] <= low[x - 1]) & (d[x] <= low[x]) & (d[x] <= low[x + 1]);
    mark[x] = top | bottom;
  }
}

/// Finds the pixels that are extrema of their 26 neighbours, row by row.
class RowSearch {
 public:
  RowSearch(const Octave& octave, float threshold)
      : octave_(octave), width_(octave[0].width()), threshold_(threshold) {
    const auto width = static_cast<std::size_t>(width_);
    for (auto& level : difference_)
      for (auto& row : level) row.resize(width);
    for (auto* ranges : {&low_, &high_})
      for (auto& row : *ranges) row.resize(width);
    least_.resize(width);
    greatest_.resize(width);
    mark_.resize(width);
  }

  void subtractRow(int y) {
    for (std::size_t l = 0; l < kDifferences; ++l)
      subtract(octave_[l + 1].row(y), octave_[l].row(y), width_, row(l, y));
  }

  /// found(level, x) for the extrema of row y, once rows y - 1 to y + 1 have been subtracted.
  template <class Found>
  void search(int y, const Found& found) {
    for (std::size_t l = 0; l < kDifferences; ++l) {
      leastOf(row(l, y - 1), row(l, y), row(l, y + 1), width_, low_[l].data());
      greatestOf(row(l, y - 1), row(l, y), row(l, y + 1), width_, high_[l].data());
    }
    for (std::size_t l = 1; l <= kScales; ++l) {
      leastOf(low_[l - 1].data(), low_[l].data(), low_[l + 1].data(), width_, least_.data());
      greatestOf(high_[l - 1].data(), high_[l].data(), high_[l + 1].data(), width_,
                 greatest_.data());
      markExtrema(row(l, y), least_.data(), greatest_.data(), threshold_, kBorder, width_ - kBorder,
                  mark_.data());
      for (int x = kBorder; x < width_ - kBorder; ++x)
        if (mark_[static_cast<std::size_t>(x)]) found(static_cast<int>(l), x);
    }
  }

 private:
  static constexpr std::size_t kDifferences = kLevels - 1;
  using Row = std::vector<float>;

  float* row(std::size_t level, int y) {
    return difference_[level][static_cast<std::size_t>(y % 3)].data();
  }

  const Octave& octave_;
  const int width_;
  const float threshold_;
  std::array<std::array<Row, 3>, kDifferences> difference_;  ///< by level, then row modulo 3
  std::array<Row, kDifferences> low_, high_;                 ///< over three rows
  Row least_, greatest_;                                     ///< over three rows and levels
  std::vector<std::int32_t> mark_;
};

/// Section 4: Newton steps on the quadratic through the neighbours, then the tests.
std::optional<Keypoint> fit(const Octave& octave, int level, int x, int y, float contrast) {
  const int width = octave[0].width(), height = octave[0].height();
  for (int move = 0; move < kMoves; ++move) {
    const auto at = [&](int dl, int dy, int dx) {
      const auto l = static_cast<std::size_t>(level + dl);
      return octave[l + 1].row(y + dy)[x + dx] - octave[l].row(y + dy)[x + dx];
    };
    const float d = at(0, 0, 0);
    const float gx = (at(0, 0, 1) - at(0, 0, -1)) / 2;
    const float gy = (at(0, 1, 0) - at(0, -1, 0)) / 2;
    const float gs = (at(1, 0, 0) - at(-1, 0, 0)) / 2;
    const float xx = at(0, 0, 1) + at(0, 0, -1) - 2 * d;
    const float yy = at(0, 1, 0) + at(0, -1, 0) - 2 * d;
    const float ss = at(1, 0, 0) + at(-1, 0, 0) - 2 * d;
    const float xy = (at(0, 1, 1) - at(0, 1, -1) - at(0, -1, 1) + at(0, -1, -1)) / 4;
    const float xs = (at(1, 0, 1) - at(1, 0, -1) - at(-1, 0, 1) + at(-1, 0, -1)) / 4;
    const float ys = (at(1, 1, 0) - at(1, -1, 0) - at(-1, 1, 0) + at(-1, -1, 0)) / 4;
    // Adjugate of the symmetric Hessian.
    const float cxx = yy * ss - ys * ys, cxy = xs * ys - xy * ss, cxs = xy * ys - xs * yy;
    const float cyy = xx * ss - xs * xs, cys = xy * xs - xx * ys, css = xx * yy - xy * xy;
    const float determinant = xx * cxx + xy * cxy + xs * cxs;
    if (determinant == 0) return std::nullopt;
    const float ox = -(cxx * gx + cxy * gy + cxs * gs) / determinant;
    const float oy = -(cxy * gx + cyy * gy + cys * gs) / determinant;
    const float os = -(cxs * gx + cys * gy + css * gs) / determinant;
    if (std::abs(ox) < 0.5f && std::abs(oy) < 0.5f && std::abs(os) < 0.5f) {
      const float response = std::abs(d + (gx * ox + gy * oy + gs * os) / 2);
      const float trace = xx + yy;
      constexpr float kEdge = (kEdgeRatio + 1) * (kEdgeRatio + 1) / kEdgeRatio;
      if (response * kScales < contrast || css <= 0 || trace * trace >= kEdge * css)
        return std::nullopt;
      return Keypoint{0, static_cast<float>(x) + ox, static_cast<float>(y) + oy,
                      static_cast<float>(level) + os, response};
    }
    if (!(std::abs(ox) < 1e6f && std::abs(oy) < 1e6f && std::abs(os) < 1e6f)) return std::nullopt;
    x += static_cast<int>(std::lround(ox));
    y += static_cast<int>(std::lround(oy));
    level += static_cast<int>(std::lround(os));
    if (level < 1 || level > kScales || x < kBorder || x >= width - kBorder || y < kBorder ||
        y >= height - kBorder)
      return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace

void findExtrema(const Octave& octave, int octave_index, double contrast,
                 std::vector<Keypoint>& keypoints) {
  const int height = octave[0].height();
  if (octave[0].width() <= 2 * kBorder || height <= 2 * kBorder) return;
  const auto threshold = static_cast<float>(contrast);
  // The fit can raise the contrast: pixels with half of it are tried.
  RowSearch rows(octave, threshold / (2 * kScales));
  rows.subtractRow(kBorder - 1);
  rows.subtractRow(kBorder);
  for (int y = kBorder; y < height - kBorder; ++y) {
    rows.subtractRow(y + 1);
    rows.search(y, [&](int level, int x) {
      auto keypoint = fit(octave, level, x, y, threshold);
      if (!keypoint) return;
      keypoint->octave = octave_index;
      keypoints.push_back(*keypoint);
    });
  }
}

}  // namespace cf::sift
