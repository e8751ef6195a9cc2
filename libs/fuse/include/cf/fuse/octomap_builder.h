// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <filesystem>
#include <memory>

#include "cf/base/options.h"
#include "cf/types/map_point.h"
#include "cf/types/tile.h"

namespace cf {

/// Section [octomap].
struct OctomapOptions {
  double resolution_m = 0;         ///< of occupied space; 0 = automatic, see resolved()
  double free_resolution_m = 1.0;  ///< of free space; rounded to the next cell size of the octree
  int rays_per_keyframe = 2000;    ///< 0 = no free space

  void visit(OptionVisitor& visitor);
  /// With resolution_m chosen where it is automatic: four voxels of the fused map, or 8, 16… where
  /// its ground, of `area_m2`, would be more than two million cells: memory stays bounded.
  OctomapOptions resolved(double voxel_m, double area_m2) const;
};

/// Builds an octomap::ColorOcTree (Hornung et al. 2013): occupied space with colour at fine
/// resolution, free space carved along rays at a coarse one, where fine rays from a hundred metres
/// up would cost a hundred times more. A coarse cell with occupied space in it is never marked
/// free.
///
/// Give the surface first, then carve: rays end where they first meet it.
class OctoMapBuilder {
 public:
  struct Stats {
    std::size_t occupied_cells = 0;  ///< of resolution_m
    std::size_t free_cells = 0;      ///< of the coarse resolution
    std::size_t outside = 0;         ///< points beyond the 65,536 cells of an octree, left out
  };

  /// Throws UsageError where options.resolution_m is still 0.
  explicit OctoMapBuilder(const OctomapOptions& options);
  ~OctoMapBuilder();
  OctoMapBuilder(const OctoMapBuilder&) = delete;
  OctoMapBuilder& operator=(const OctoMapBuilder&) = delete;

  /// Marks the voxels of a finished tile as occupied: a hit for each depth frame that saw one.
  /// Colours are means weighted by confidence.
  void addSurface(const Tile& tile);
  /// Marks what is between a camera and the points of its depth frame as free, along
  /// rays_per_keyframe rays spread evenly over the points. Weights do not matter.
  void carve(const Eigen::Vector3d& camera_centre_m, const MapPoints& seen);

  /// BASE.ot with colour and BASE.bt with occupancy alone, each atomically. Throws RunError.
  void write(const std::filesystem::path& base) const;

  Stats stats() const;
  double resolution() const;      ///< [m]
  double freeResolution() const;  ///< [m]

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cf
