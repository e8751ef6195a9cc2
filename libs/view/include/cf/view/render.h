// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "cf/view/scene_inputs.h"
#include "cf/view/view_camera.h"

namespace cf {

/// Colour of one UAV in every picture, RGB: white for the central one, never red (relative poses).
/// `index` counts the other UAVs in order of name.
Eigen::Matrix<std::uint8_t, 3, 1> uavColour(bool central, std::size_t index);

/// Renders with MRPT's offscreen renderer (EGL, no display needed) after the style of the paper's
/// Fig. 1 and writes a PNG atomically: the cloud in its own colours, by height for kHeight, and for
/// kOctomap scene.voxels.
/// Throws RunError if the renderer cannot start or the file cannot be written.
void renderSnapshot(const SceneInputs& scene, const View& view, ImageSize size,
                    const std::filesystem::path& png);

/// Writes the MRPT scene (cloud, trajectories, relative poses) that SceneViewer3D opens; it appears
/// whole or not at all. Throws RunError if it cannot be written.
void writeScene(const SceneInputs& scene, const std::filesystem::path& file);

/// The pictures of a finished run, into OUTDIR/snapshots (top, iso, front, height, octomap and one
/// for each UAV), and OUTDIR/map.3Dscene. Returns the files written. The octomap view is left out
/// when there is no octomap.ot. `side_by_side`: several pictures are on their way at a time, which
/// takes more memory.
std::vector<std::filesystem::path> renderRun(const std::filesystem::path& outdir, ImageSize size,
                                             bool side_by_side = true);

}  // namespace cf
