// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "cf/deliver/orthophoto.h"
#include "ortho_surface.h"
#include "ortho_tones.h"
#include "ortho_views.h"

namespace cf {

/// What every window of an orthophoto is made from.
struct OrthoScene {
  const OrthoSurface& surface;
  const GridFrame& grid;
  const std::vector<OrthoPhoto>& photos;
  const std::vector<double>& sight_limits;  ///< sightLimit() of each photo's camera
  const std::vector<std::vector<OrthoCandidate>>& candidates;  ///< by cell of the lattice
  const OrthoTones& tones;
};

/// The surface under one window and who sees its nodes, which are counted from the window's first.
class OrthoGround {
 public:
  /// Nodes that a sight is followed towards the camera.
  static constexpr int kSightReach = 96;

  /// `nodes` of the surface. With `sights`, free() can be asked.
  OrthoGround(const OrthoScene& scene, const cv::Rect& nodes, bool sights);

  const cv::Rect& nodes() const { return nodes_; }
  PhotoProjection projection(int photo) const;
  bool shown(int x, int y) const {
    return window_.shown.at<std::uint8_t>(y + reach_, x + reach_) != 0;
  }
  /// What projection() takes.
  Eigen::Vector3d local(int x, int y) const {
    return {(x - nodes_.width / 2) * node_m_, (nodes_.height / 2 - y) * node_m_,
            static_cast<double>(height(x, y) - place_z_)};
  }
  /// 1: nothing is between the node at `place` and the camera, 0: hidden. `top`: greatest height
  /// around [m].
  float free(const PhotoProjection& view, const Eigen::Vector3d& place, int x, int y,
             float top) const;

 private:
  float height(int x, int y) const { return window_.heights.at<float>(y + reach_, x + reach_); }

  const OrthoScene& scene_;
  const cv::Rect nodes_;
  const int reach_;
  const double node_m_;
  OrthoSurface::Window window_;
  float place_z_ = 0;
  Eigen::Affine3d T_world_local_;
};

}  // namespace cf
