// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>

namespace cf {

/// Position and direction in the plane; angle from x (east) towards y (north) [rad].
struct Course {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  double angle = 0;
};

/// A piece of a path of constant curvature [1/m], positive to the left.
struct PathPiece {
  Course start;
  double length = 0;
  double curvature = 0;

  Course at(double s) const;
};

/// Shortest path between two courses with turns of one radius: L. E. Dubins, "On curves of minimal
/// length with a constraint on average curvature", 1957; all six words are tried.
std::array<PathPiece, 3> dubinsPath(const Course& from, const Course& to, double radius);

}  // namespace cf
