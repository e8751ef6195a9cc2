// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "dubins.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cf {
namespace {

constexpr double kTurn = 2 * M_PI;

Eigen::Vector2d direction(double angle) { return {std::cos(angle), std::sin(angle)}; }
Eigen::Vector2d leftOf(double angle) { return {-std::sin(angle), std::cos(angle)}; }
double angleOf(const Eigen::Vector2d& v) { return std::atan2(v.y(), v.x()); }

/// 0 to 2 pi; what rounding leaves of a whole turn is none.
double positive(double angle) {
  constexpr double kRounding = 1e-9;
  const double a = std::fmod(std::fmod(angle, kTurn) + kTurn, kTurn);
  return a > kTurn - kRounding ? 0 : a;
}

using Pieces = std::array<PathPiece, 3>;

/// Three pieces with these lengths in a row; sides: 1 left, 0 straight, -1 right.
Pieces chain(const Course& from, double radius, const std::array<int, 3>& sides,
             const std::array<double, 3>& lengths) {
  Pieces pieces;
  Course course = from;
  for (std::size_t i = 0; i < 3; ++i) {
    pieces[i] = {course, lengths[i], sides[i] / radius};
    course = pieces[i].at(lengths[i]);
  }
  return pieces;
}

double lengthOf(const Pieces& pieces) {
  return pieces[0].length + pieces[1].length + pieces[2].length;
}

/// Arc, tangent, arc; `a`, `b` the sides of the arcs.
void tryStraight(const Course& from, const Course& to, double r, int a, int b, Pieces& best,
                 double& shortest) {
  const Eigen::Vector2d c1 = from.position + a * r * leftOf(from.angle);
  const Eigen::Vector2d c2 = to.position + b * r * leftOf(to.angle);
  const double d = (c2 - c1).norm();
  // The tangent runs at this angle to the line between the centres.
  const double inner = a == b ? 0 : 2 * r / std::max(d, 1e-12);
  if (inner > 1) return;
  const double tangent = (d > 0 ? angleOf(c2 - c1) : from.angle) + a * std::asin(inner);
  const double straight = std::sqrt(std::max(0.0, d * d - (a == b ? 0 : 4 * r * r)));
  const Pieces pieces = chain(
      from, r, {a, 0, b},
      {r * positive(a * (tangent - from.angle)), straight, r * positive(b * (to.angle - tangent))});
  if (lengthOf(pieces) >= shortest) return;
  shortest = lengthOf(pieces);
  best = pieces;
}

/// Three arcs, the middle one to the other side.
void tryCurved(const Course& from, const Course& to, double r, int a, Pieces& best,
               double& shortest) {
  const Eigen::Vector2d c1 = from.position + a * r * leftOf(from.angle);
  const Eigen::Vector2d c3 = to.position + a * r * leftOf(to.angle);
  const double d = (c3 - c1).norm();
  if (d > 4 * r || d <= 0) return;
  const double line = angleOf(c3 - c1), bend = std::acos(d / (4 * r));
  for (const int side : {1, -1}) {
    const Eigen::Vector2d c2 = c1 + 2 * r * direction(line + side * bend);
    // Directions of travel where the circles touch.
    const double at12 = angleOf(c2 - c1) + a * M_PI / 2, at23 = angleOf(c2 - c3) + a * M_PI / 2;
    const Pieces pieces =
        chain(from, r, {a, -a, a},
              {r * positive(a * (at12 - from.angle)), r * positive(-a * (at23 - at12)),
               r * positive(a * (to.angle - at23))});
    if (lengthOf(pieces) >= shortest) continue;
    shortest = lengthOf(pieces);
    best = pieces;
  }
}

}  // namespace

Course PathPiece::at(double s) const {
  if (curvature == 0) return {start.position + s * direction(start.angle), start.angle};
  const double angle = start.angle + s * curvature;
  return {start.position + (leftOf(start.angle) - leftOf(angle)) / curvature, angle};
}

Pieces dubinsPath(const Course& from, const Course& to, double radius) {
  Pieces best{};
  double shortest = std::numeric_limits<double>::infinity();
  for (const int a : {1, -1}) {
    for (const int b : {1, -1}) tryStraight(from, to, radius, a, b, best, shortest);
    tryCurved(from, to, radius, a, best, shortest);
  }
  return best;
}

}  // namespace cf
