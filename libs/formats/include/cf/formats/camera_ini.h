// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "cf/types/camera_model.h"

namespace cf {

/// Reads one section of an ini: width, height, fx, fy, cx, cy [px], k1, k2, p1, p2, k3
/// (OpenCV's order and sign), focal_sigma [px], k1_sigma, k2_sigma. Needed are width, height and
/// fx; fy is fx, the principal point the centre, and all else zero unless given (a sigma of zero
/// holds the value fixed, all three of them the whole calibration). Other sections are skipped, so
/// that cameras/<uav>.ini of a run serves as input. Throws UsageError naming file and key.
CameraModel readCameraIni(const std::filesystem::path& file, const std::string& section = "camera");

}  // namespace cf
