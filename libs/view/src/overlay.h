// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>
#include <string>

#include "cf/view/scene_inputs.h"
#include "cf/view/view_camera.h"
#include "scene_objects.h"

namespace cf {

/// Names of the UAVs in their colours: upper left, or lower left where trajectories are above.
void drawUavLegend(cv::Mat& picture, const SceneInputs& scene, bool at_bottom);
/// A bar of a round length, lower left; parallel projection only.
void drawScaleBar(cv::Mat& picture, const ViewCamera& camera);
/// Arrow to the north as the ground shows it, upper right; none where north is into the picture.
void drawNorthArrow(cv::Mat& picture, const ViewCamera& camera);
/// The colour ramp with heights in metres, right.
void drawHeightLegend(cv::Mat& picture, const HeightRange& range, const SceneInputs& scene);

/// 1, 2 or 5 times a power of ten: the largest not above `value`.
double roundBelow(double value);

}  // namespace cf
