// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>
#include <vector>

#include "cf/simulate/flight_plan.h"
#include "dubins.h"

namespace cf {

/// The undisturbed way over the ground, by arc length [m].
class FlightPath {
 public:
  FlightPath(const FlightOptions& options, const Footprint& footprint);

  /// Before the start and after the end it goes straight on. Angles do not wrap.
  Course at(double s) const;
  double length() const { return length_; }
  /// Begin and end of each strip, where photos are taken.
  const std::vector<std::pair<double, double>>& strips() const { return strips_; }

 private:
  void add(const PathPiece& piece);
  void addStrip(const Course& begin, double strip_m, double lead_m, double radius_m);

  std::vector<PathPiece> pieces_;
  std::vector<double> starts_;  ///< arc length at the start of each piece
  std::vector<std::pair<double, double>> strips_;
  double length_ = 0;
};

}  // namespace cf
