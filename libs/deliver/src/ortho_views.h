// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "cf/deliver/orthophoto.h"
#include "cf/geodesy/grid_frame.h"
#include "ortho_surface.h"

namespace cf {

/// Squared distance from the axis, on the normalized plane, of a camera's farthest corner: beyond
/// it lens distortion may fold over.
double sightLimit(const CameraModel& camera);

/// How places around one of the map fall into a photo.
class PhotoProjection {
 public:
  /// `T_world_local`: from grid coordinates relative to the place, GridFrame's affine map.
  PhotoProjection(const OrthoPhoto& photo, double sight_limit,
                  const Eigen::Affine3d& T_world_local);

  struct Sight {
    float u = 0, v = 0;   ///< [px] of the original photo
    float border = -1;    ///< distance to its border over its width; negative: not in it
    float steepness = 0;  ///< tangent of the angle between the sight and the vertical
  };
  Sight project(const Eigen::Vector3d& p) const;
  /// Without the steepness.
  Sight place(const Eigen::Vector3d& p) const;
  /// Of the sight alone, wherever it falls.
  float steepness(const Eigen::Vector3d& p) const {
    return static_cast<float>((centre_ - p).head<2>().norm() / (centre_.z() - p.z()));
  }
  const Eigen::Vector3d& centre() const { return centre_; }  ///< of the camera, local

 private:
  Eigen::Matrix3d A_;
  Eigen::Vector3d b_, centre_;
  CameraModel camera_;
  double sight_limit_;
};

/// From grid coordinates relative to `place_grid` to the world, exact there.
Eigen::Affine3d T_world_local(const GridFrame& grid, const Eigen::Vector3d& place_grid);

/// How good a photo is for a place, 0 the best: its steepness, more towards its border.
float demerit(const PhotoProjection::Sight& sight);
/// Towards the border photos count less.
constexpr float kOrthoBorder = 0.04F;

/// A photo that sees a cell of the lattice.
struct OrthoCandidate {
  int photo = 0;
  float demerit = 0;
  float u = 0, v = 0;
  bool whole = false;  ///< all of the cell is inside the photo and off its border
};

/// For each cell of the surface's lattice (row by row) the photos that see it, the best first. A
/// cell at the rim of a photo counts as seen.
std::vector<std::vector<OrthoCandidate>> orthoCandidates(const OrthoSurface& surface,
                                                         const GridFrame& grid,
                                                         const std::vector<OrthoPhoto>& photos);

/// How many of a cell's candidates a picture may be made of: those nearly as good as the best, and
/// some more in case it is hidden there.
std::size_t orthoShortlist(const std::vector<OrthoCandidate>& candidates);

}  // namespace cf
