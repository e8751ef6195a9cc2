// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "surface_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <opencv2/core.hpp>

namespace cf {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
constexpr float kGap = 4;           ///< cells between surfaces, one above the other
constexpr float kTopThickness = 3;  ///< cells: the height of a voxel
constexpr float kSupportShare = 0.25F;
constexpr float kTopShare = 0.3F;
constexpr float kSmoothStep = 3;
constexpr float kCompanionStep = 2;
constexpr int kCompanions = 3, kFewCompanions = 8;
constexpr float kDoubtfulShare = 0.5F;
constexpr int kDirections = 8;
constexpr int kDirectionsNeeded = 6;
const std::array<cv::Point, kDirections> kCompass = {
    {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}}};

struct Top {
  float z = kNone;
  float views = 0;
};

/// The uppermost surface of the points of one cell, which are sorted here.
Top topOf(SurfacePoint* begin, SurfacePoint* end) {
  std::sort(begin, end, [](const SurfacePoint& a, const SurfacePoint& b) { return a.z > b.z; });
  const auto surfaceEnd = [&](const SurfacePoint* p) {
    do ++p;
    while (p != end && (p - 1)->z - p->z < kGap);
    return p;
  };
  const auto viewsOf = [](const SurfacePoint* p, const SurfacePoint* q) {
    return std::accumulate(p, q, 0.F,
                           [](float sum, const SurfacePoint& s) { return sum + s.views; });
  };
  float best_views = 0;
  for (const SurfacePoint* p = begin; p != end; p = surfaceEnd(p))
    best_views = std::max(best_views, viewsOf(p, surfaceEnd(p)));
  const SurfacePoint* p = begin;
  while (viewsOf(p, surfaceEnd(p)) < kSupportShare * best_views) p = surfaceEnd(p);
  // Its top: what lies above with little weight is noise.
  const SurfacePoint* const bottom = surfaceEnd(p);
  const float best = std::max_element(p, bottom, [](const SurfacePoint& a, const SurfacePoint& b) {
                       return a.confidence < b.confidence;
                     })->confidence;
  while (p->confidence < kTopShare * best) ++p;
  Top top;
  float weight = 0, sum = 0;
  for (const SurfacePoint* q = p; q != bottom && p->z - q->z <= kTopThickness; ++q) {
    weight += q->confidence;
    sum += q->confidence * (q->z - p->z);
    top.views += q->views;
  }
  top.z = p->z + (weight > 0 ? sum / weight : 0);
  return top;
}

/// Whether a cell has too little in common with those around it. `seen`: views of each.
bool isLoner(const cv::Mat& heights, const cv::Mat& seen, int x, int y) {
  const float z = heights.at<float>(y, x);
  int companions = -1, others = 0;  // itself is no companion
  float seen_others = 0;
  for (int v = std::max(0, y - 2); v <= std::min(heights.rows - 1, y + 2); ++v) {
    const auto *row = heights.ptr<float>(v), *seen_row = seen.ptr<float>(v);
    for (int u = std::max(0, x - 2); u <= std::min(heights.cols - 1, x + 2); ++u) {
      if (std::abs(row[u] - z) < kCompanionStep) {
        ++companions;
      } else if (!std::isnan(row[u])) {
        ++others;
        seen_others += seen_row[u];
      }
    }
  }
  const bool doubtful =
      companions < kFewCompanions && companions < others &&
      seen.at<float>(y, x) * static_cast<float>(others) < kDoubtfulShare * seen_others;
  return companions < kCompanions || doubtful;
}

cv::Mat withoutLoners(const cv::Mat& heights, const cv::Mat& seen) {
  cv::Mat out = heights.clone();
  for (int y = 0; y < heights.rows; ++y) {
    const auto* row = heights.ptr<float>(y);
    for (int x = 0; x < heights.cols; ++x) {
      if (std::isnan(row[x])) continue;
      // Eight companions next to it are enough.
      bool surrounded = y > 0 && y + 1 < heights.rows && x > 0 && x + 1 < heights.cols;
      for (int v = -1; surrounded && v <= 1; ++v) {
        const auto* near = heights.ptr<float>(y + v) + x;
        for (int u = -1; u <= 1; ++u)
          surrounded = surrounded && std::abs(near[u] - row[x]) < kCompanionStep;
      }
      if (!surrounded && isLoner(heights, seen, x, y)) out.at<float>(y, x) = kNone;
    }
  }
  return out;
}

cv::Mat smoothed(const cv::Mat& heights) {
  cv::Mat out = heights.clone();
  for (int y = 1; y + 1 < heights.rows; ++y)
    for (int x = 1; x + 1 < heights.cols; ++x) {
      const float z = heights.at<float>(y, x);
      if (std::isnan(z)) continue;
      float sum = 0, weight = 0;
      // Opposite neighbours count together or not at all: a slope is not bent at its edges.
      for (int k = 0; k < kDirections / 2; ++k) {
        const cv::Point d = kCompass[static_cast<std::size_t>(k)];
        const float a = heights.at<float>(y + d.y, x + d.x) - z;
        const float b = heights.at<float>(y - d.y, x - d.x) - z;
        if (!(std::abs(a) < kSmoothStep && std::abs(b) < kSmoothStep)) continue;
        const float w = d.x != 0 && d.y != 0 ? 0.5F : 1.F;
        sum += w * (a + b);
        weight += 2 * w;
      }
      out.at<float>(y, x) = z + sum / (weight + 1);
    }
  return out;
}

}  // namespace

cv::Mat uppermostSurface(const std::vector<SurfacePoint>& points, cv::Size size) {
  const auto cellOf = [&](const SurfacePoint& p) -> std::int64_t {
    const float x = std::floor(p.x), y = std::floor(p.y);
    if (!(x >= 0 && y >= 0 && x < static_cast<float>(size.width) &&
          y < static_cast<float>(size.height)))
      return -1;
    return static_cast<std::int64_t>(y) * size.width + static_cast<std::int64_t>(x);
  };
  // Points by cell: a counting sort.
  std::vector<std::uint32_t> begins(static_cast<std::size_t>(size.area()) + 1, 0);
  for (const SurfacePoint& p : points)
    if (const auto cell = cellOf(p); cell >= 0) ++begins[static_cast<std::size_t>(cell) + 1];
  for (std::size_t i = 1; i < begins.size(); ++i) begins[i] += begins[i - 1];
  std::vector<SurfacePoint> sorted(begins.back());
  std::vector<std::uint32_t> next(begins.begin(), begins.end() - 1);
  for (const SurfacePoint& p : points)
    if (const auto cell = cellOf(p); cell >= 0) sorted[next[static_cast<std::size_t>(cell)]++] = p;
  cv::Mat heights(size, CV_32FC1, cv::Scalar(kNone));
  cv::Mat views = cv::Mat::zeros(size, CV_32FC1);
  for (std::size_t cell = 0; cell + 1 < begins.size(); ++cell) {
    if (begins[cell] == begins[cell + 1]) continue;
    const Top top = topOf(sorted.data() + begins[cell], sorted.data() + begins[cell + 1]);
    heights.ptr<float>()[cell] = top.z;
    views.ptr<float>()[cell] = top.views;
  }
  return smoothed(withoutLoners(heights, views));
}

cv::Mat withHolesFilled(const cv::Mat& heights, int reach, float step) {
  cv::Mat out = heights.clone();
  for (int y = 0; y < heights.rows; ++y)
    for (int x = 0; x < heights.cols; ++x) {
      const float* const here = heights.ptr<float>(y) + x;
      if (!std::isnan(*here)) continue;
      std::array<float, kDirections> z{}, distance{};
      int found = 0;
      for (int k = 0; k < kDirections && found + kDirections - k >= kDirectionsNeeded; ++k) {
        const cv::Point d = kCompass[static_cast<std::size_t>(k)];
        const int room_x = d.x > 0 ? heights.cols - 1 - x : d.x < 0 ? x : reach;
        const int room_y = d.y > 0 ? heights.rows - 1 - y : d.y < 0 ? y : reach;
        const int room = std::min({reach, room_x, room_y});
        const std::ptrdiff_t stride = d.y * static_cast<std::ptrdiff_t>(heights.step1()) + d.x;
        int steps = 1;
        while (steps <= room && std::isnan(here[steps * stride])) ++steps;
        if (steps > room) continue;
        z[static_cast<std::size_t>(found)] = here[steps * stride];
        distance[static_cast<std::size_t>(found)] =
            static_cast<float>(steps) * (d.x != 0 && d.y != 0 ? 1.4142F : 1.F);
        ++found;
      }
      if (found < kDirectionsNeeded) continue;
      const float low = *std::min_element(z.begin(), z.begin() + found);
      float sum = 0, weight = 0;
      for (std::size_t k = 0; k < static_cast<std::size_t>(found); ++k) {
        if (z[k] - low > step) continue;
        const float w = 1 / (distance[k] * distance[k]);
        sum += w * (z[k] - low);
        weight += w;
      }
      out.at<float>(y, x) = low + sum / weight;
    }
  return out;
}

}  // namespace cf
