// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "elas_prior.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "cf/densify/stereo_matcher.h"
#include "delaunay.h"

namespace cf {
namespace {

constexpr int kFixedBits = 16;

/// The image's corners with the disparities of the points nearest by, so that triangles cover it.
void addCorners(std::vector<SupportPoint>& points, cv::Size size) {
  const std::size_t given = points.size();
  if (given == 0) return;
  for (const cv::Point corner :
       {cv::Point(0, 0), cv::Point(size.width - 1, 0), cv::Point(0, size.height - 1),
        cv::Point(size.width - 1, size.height - 1)}) {
    double least = std::numeric_limits<double>::infinity();
    int d = 0;
    for (std::size_t k = 0; k < given; ++k) {
      const double distance = std::hypot(points[k].u - corner.x, points[k].v - corner.y);
      if (distance >= least) continue;
      least = distance;
      d = points[k].d;
    }
    points.push_back({corner.x, corner.y, d});
  }
}

/// Sorted as the triangulation wants them, one at each place.
std::vector<SupportPoint> sorted(std::vector<SupportPoint> points) {
  const auto place = [](const SupportPoint& p) { return std::make_pair(p.u, p.v); };
  std::stable_sort(points.begin(), points.end(),
                   [&](const auto& a, const auto& b) { return place(a) < place(b); });
  points.erase(std::unique(points.begin(), points.end(),
                           [&](const auto& a, const auto& b) { return place(a) == place(b); }),
               points.end());
  return points;
}

void drawPlane(const SupportPoint& a, const SupportPoint& b, const SupportPoint& c,
               cv::Mat& plane) {
  Eigen::Matrix2d sides;
  sides << b.u - a.u, b.v - a.v, c.u - a.u, c.v - a.v;
  const Eigen::Vector2d slope = sides.inverse() * Eigen::Vector2d(b.d - a.d, c.d - a.d);
  // In fixed point, rounded by the half.
  const auto across = static_cast<int>(std::lround(slope.x() * (16 << kFixedBits)));
  const SupportPoint* corners[] = {&a, &b, &c};
  const auto [top, bottom] = std::minmax({a.v, b.v, c.v});
  for (int v = std::max(0, top); v <= std::min(plane.rows - 1, bottom); ++v) {
    double first = plane.cols, last = -1;
    for (int k = 0; k < 3; ++k) {
      const SupportPoint& p = *corners[k];
      const SupportPoint& q = *corners[(k + 1) % 3];
      if (std::min(p.v, q.v) > v || std::max(p.v, q.v) < v) continue;
      for (const SupportPoint* end : {&p, &q}) {
        const double at =
            p.v == q.v ? end->u : p.u + static_cast<double>(v - p.v) * (q.u - p.u) / (q.v - p.v);
        first = std::min(first, at);
        last = std::max(last, at);
      }
    }
    auto* row = plane.ptr<std::int16_t>(v);
    const double d = a.d - slope.x() * a.u + slope.y() * (v - a.v);
    const std::int64_t at_zero = std::llround((16 * d + 0.5) * (1 << kFixedBits));
    const int end = std::min(plane.cols - 1, static_cast<int>(std::floor(last)));
    for (int u = std::max(0, static_cast<int>(std::ceil(first))); u <= end; ++u) {
      row[u] = static_cast<std::int16_t>((at_zero + static_cast<std::int64_t>(across) * u) >>
                                         kFixedBits);
    }
  }
}

}  // namespace

ElasPrior::ElasPrior(const std::vector<SupportPoint>& points, cv::Size size)
    : plane(size, CV_16S, cv::Scalar(kNoDisparity)),
      columns(static_cast<std::size_t>((size.width + kCell - 1) / kCell)) {
  const int rows = (size.height + kCell - 1) / kCell, width = static_cast<int>(columns);
  std::vector<SupportPoint> all = points;
  addCorners(all, size);
  all = sorted(std::move(all));
  std::vector<cv::Point> places;
  for (const SupportPoint& p : all) places.emplace_back(p.u, p.v);
  for (const auto& t : delaunayTriangles(places)) {
    const auto at = [&](int k) -> const SupportPoint& {
      return all[static_cast<std::size_t>(t[static_cast<std::size_t>(k)])];
    };
    drawPlane(at(0), at(1), at(2), plane);
  }
  // By cell, then those of the cells around each.
  std::vector<std::vector<int>> has(columns * static_cast<std::size_t>(rows));
  const auto index = [&](int x, int y) { return static_cast<std::size_t>(y * width + x); };
  for (const SupportPoint& p : all) has[index(p.u / kCell, p.v / kCell)].push_back(p.d);
  std::vector<int> around;
  starts.push_back(0);
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < width; ++i) {
      around.clear();
      for (int y = std::max(0, j - 1); y <= std::min(rows - 1, j + 1); ++y) {
        for (int x = std::max(0, i - 1); x <= std::min(width - 1, i + 1); ++x) {
          const auto& cell = has[index(x, y)];
          around.insert(around.end(), cell.begin(), cell.end());
        }
      }
      std::sort(around.begin(), around.end());
      values.insert(values.end(), around.begin(), std::unique(around.begin(), around.end()));
      starts.push_back(values.size());
    }
  }
}

}  // namespace cf
