// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "flight_path.h"

#include <algorithm>
#include <cmath>

namespace cf {
namespace {

/// Where strips begin, to and fro over a rectangle.
std::vector<Course> stripsOver(const Eigen::Vector2d& center, double length, double width,
                               double angle, double spacing) {
  const Eigen::Vector2d along(std::cos(angle), std::sin(angle)), right(along.y(), -along.x());
  const int count = std::max(1, static_cast<int>(std::ceil(width / spacing - 1e-9)));
  std::vector<Course> strips;
  for (int i = 0; i < count; ++i) {
    const double across = ((i + 0.5) / count - 0.5) * width;
    const int way = i % 2 == 0 ? 1 : -1;
    strips.push_back(
        {center + across * right - way * length / 2 * along, way == 1 ? angle : angle + M_PI});
  }
  return strips;
}

}  // namespace

FlightPath::FlightPath(const FlightOptions& o, const Footprint& footprint) {
  const double spacing = (1 - o.side_overlap) * footprint.across_m;
  const double angle = (90 - o.heading_deg) * M_PI / 180;
  const Eigen::Vector2d center(o.center_e_m, o.center_n_m);
  // Turns end a little before the photos begin; a wing needs some way to roll out of them.
  constexpr double kLead_s = 0.5;
  const double lead = o.mount == "fixed" ? o.turn_radius_m : kLead_s * o.speed_mps;
  for (const Course& begin : stripsOver(center, o.length_m, o.width_m, angle, spacing))
    addStrip(begin, o.length_m, lead, o.turn_radius_m);
  if (o.pattern != "double") return;
  for (const Course& begin : stripsOver(center, o.width_m, o.length_m, angle + M_PI / 2, spacing))
    addStrip(begin, o.width_m, lead, o.turn_radius_m);
}

void FlightPath::add(const PathPiece& piece) {
  pieces_.push_back(piece);
  starts_.push_back(length_);
  length_ += piece.length;
}

void FlightPath::addStrip(const Course& begin, double strip_m, double lead_m, double radius_m) {
  const Eigen::Vector2d along(std::cos(begin.angle), std::sin(begin.angle));
  Course start{begin.position - lead_m * along, begin.angle};
  if (!pieces_.empty()) {
    const PathPiece& last = pieces_.back();
    for (const PathPiece& piece : dubinsPath(last.at(last.length), start, radius_m)) add(piece);
    start.angle = pieces_.back().at(pieces_.back().length).angle;
  }
  strips_.emplace_back(length_ + lead_m, length_ + lead_m + strip_m);
  add({start, strip_m + 2 * lead_m, 0});
}

Course FlightPath::at(double s) const {
  const auto next = std::upper_bound(starts_.begin() + 1, starts_.end(), s);
  const std::size_t i = static_cast<std::size_t>(next - starts_.begin()) - 1;
  return pieces_[i].at(s - starts_[i]);
}

}  // namespace cf
