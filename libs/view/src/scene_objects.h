// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/opengl/CPointCloudColoured.h>
#include <mrpt/opengl/CSetOfTriangles.h>

#include <functional>
#include <opencv2/core/mat.hpp>

#include "cf/view/scene_inputs.h"
#include "cf/view/view_camera.h"

namespace cf {

/// Distance from a point to its neighbours, typical of the cloud [m].
double pointSpacing(const std::vector<ColouredPoint>& cloud);

/// The 2nd and 98th percentile of the cloud's heights [m].
struct HeightRange {
  double min_m = 0, max_m = 1;
};
HeightRange heightRange(const std::vector<ColouredPoint>& cloud);

/// Colour ramp of heights, low to high, 256 x 1 CV_8UC3 BGR (viridis: perceptually even).
cv::Mat heightRamp();

/// Points in their own colours, or by height if a range is given.
mrpt::opengl::CPointCloudColoured::Ptr cloudObject(const std::vector<ColouredPoint>& cloud,
                                                   const HeightRange* by_height);

/// Exposed faces of the voxels that face the camera, shaded by their side.
mrpt::opengl::CSetOfTriangles::Ptr voxelObject(const std::vector<Voxel>& voxels,
                                               const ViewCamera& camera);

/// Trajectories as tubes with a triangle at the end, relative poses as thin red tubes.
/// metres_per_pixel gives the size of a pixel at a world point; triangles lie in the plane of
/// right and up.
struct LineStyle {
  std::function<double(const Eigen::Vector3d&)> metres_per_pixel;
  Eigen::Vector3d right = Eigen::Vector3d::UnitX();
  Eigen::Vector3d up = Eigen::Vector3d::UnitY();
  double track_px = 5;      ///< width of a trajectory
  double link_px = 2.0;     ///< width of a relative pose
  double triangle_px = 34;  ///< length of the triangle
};
mrpt::opengl::CSetOfTriangles::Ptr lineObject(const SceneInputs& scene, const LineStyle& style);

}  // namespace cf
