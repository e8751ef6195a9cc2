// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "delaunay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <random>

namespace cf {
namespace {

using Points = std::vector<cv::Point>;

Points sorted(Points points) {
  const auto place = [](cv::Point p) { return std::make_pair(p.x, p.y); };
  std::sort(points.begin(), points.end(),
            [&](cv::Point a, cv::Point b) { return place(a) < place(b); });
  points.erase(std::unique(points.begin(), points.end()), points.end());
  return points;
}

std::int64_t twiceArea(cv::Point a, cv::Point b, cv::Point c) {
  return static_cast<std::int64_t>(b.x - a.x) * (c.y - a.y) -
         static_cast<std::int64_t>(c.x - a.x) * (b.y - a.y);
}

bool insideCircle(cv::Point a, cv::Point b, cv::Point c, cv::Point d) {
  const auto row = [&](cv::Point p) {
    const double x = p.x - d.x, y = p.y - d.y;
    return std::array<double, 3>{x, y, x * x + y * y};
  };
  const auto p = row(a), q = row(b), r = row(c);
  return p[0] * (q[1] * r[2] - q[2] * r[1]) - p[1] * (q[0] * r[2] - q[2] * r[0]) +
             p[2] * (q[0] * r[1] - q[1] * r[0]) >
         0;
}

/// Counter-clockwise, no point in any circle, and together as large as the convex hull's area.
void expectDelaunay(const Points& points, std::int64_t twice_hull) {
  std::int64_t area = 0;
  for (const auto& t : delaunayTriangles(points)) {
    const auto at = [&](std::size_t k) { return points[static_cast<std::size_t>(t[k])]; };
    EXPECT_GT(twiceArea(at(0), at(1), at(2)), 0);
    area += twiceArea(at(0), at(1), at(2));
    for (const cv::Point p : points) EXPECT_FALSE(insideCircle(at(0), at(1), at(2), p));
  }
  EXPECT_EQ(area, twice_hull);
}

TEST(Delaunay, coversRandomPoints) {
  std::mt19937 random(1);
  for (int round = 0; round < 20; ++round) {
    Points points = {{0, 0}, {999, 0}, {0, 999}, {999, 999}};
    for (int k = 0; k < 10 * round; ++k) {
      points.emplace_back(static_cast<int>(random() % 1000), static_cast<int>(random() % 1000));
    }
    expectDelaunay(sorted(points), 2 * 999 * 999);
  }
}

TEST(Delaunay, coversGridsWithHoles) {
  std::mt19937 random(2);
  Points points = {{0, 0}, {100, 0}, {0, 100}, {100, 100}};
  for (int x = 0; x <= 100; x += 5) {
    for (int y = 0; y <= 100; y += 5) {
      if (random() % 3 > 0) points.emplace_back(x, y);
    }
  }
  expectDelaunay(sorted(points), 2 * 100 * 100);
}

TEST(Delaunay, isExactFarOut) {
  expectDelaunay(sorted({{0, 0}, {16384, 0}, {0, 16384}, {16384, 16384}, {8192, 8191}}),
                 2LL * 16384 * 16384);
}

TEST(Delaunay, hasNoTriangleOnALine) {
  EXPECT_TRUE(delaunayTriangles({}).empty());
  EXPECT_TRUE(delaunayTriangles({{0, 0}, {1, 1}}).empty());
  EXPECT_TRUE(delaunayTriangles({{0, 0}, {1, 1}, {2, 2}, {3, 3}, {4, 4}, {5, 5}}).empty());
}

}  // namespace
}  // namespace cf
