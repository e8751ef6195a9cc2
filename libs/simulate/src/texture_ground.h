// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "scene_plan.h"
#include "texture_materials.h"

namespace cf {

/// What lies on the ground where: roads and their markings, gardens, fields, car parks.
class GroundPaint {
 public:
  explicit GroundPaint(const TownPlan& plan);
  /// Adds what is seen at scene coordinates (x, y) over a footprint [m].
  void paint(std::size_t sample, float x, float y, float footprint, Fragments& fragments) const;

 private:
  struct Place {
    std::size_t sample;
    float u, v, footprint;
  };
  /// The road lines on both sides of a coordinate.
  struct Lines {
    explicit Lines(const std::vector<double>& lines);
    /// Index of the last line at or below the coordinate.
    std::size_t below(float at) const;
    std::vector<float> at;
    float first = 0;
    std::vector<std::uint32_t> bins;  ///< by the metre
  };

  void paintRoad(const Place& p, float off_x, float off_y, float share, Fragments& out) const;
  void paintBlock(const Place& p, const Block& block, float share, Fragments& out) const;
  /// Returns what is left of the share.
  float paintDecals(const Place& p, Fragments& out) const;
  void paintDecal(const Place& p, const Decal& decal, float share, Fragments& out) const;

  const TownPlan& plan_;
  float cos_, sin_;
  Lines x_, y_;
  float corner_x_, corner_y_;
  int cells_across_ = 0, cells_up_ = 0;
  std::vector<std::uint32_t> cell_start_, cell_decals_;
};

}  // namespace cf
