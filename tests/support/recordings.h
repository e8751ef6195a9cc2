// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "cf/rawlog/rawlog_writer.h"

namespace cf::support {

/// A photo with a value in every field that a rawlog carries.
inline ImageFrame fullPhoto(const std::filesystem::path& rawlog, int i) {
  ImageFrame photo;
  photo.time = 1466699519 * kNsPerSecond + TimeNs{i} * 2'123'456'700;
  photo.name = "DJI_00" + std::to_string(18 + i) + ".JPG";
  photo.file = imagesFolderOf(std::filesystem::absolute(rawlog)) / photo.name;
  photo.camera.width = 4000;
  photo.camera.height = 2250;
  photo.camera.fx = 2311.2512345678901;
  photo.camera.fy = 2312.3;
  photo.camera.cx = 1999.5;
  photo.camera.cy = 1124.5;
  photo.camera.k1 = -0.0140001234;
  photo.camera.k2 = 0.0142;
  photo.camera.p1 = 0.0012;
  photo.camera.p2 = -0.0028;
  photo.camera.k3 = 1e-5;
  photo.camera.focal_sigma = 115.5625617;
  photo.camera.k1_sigma = 0.1;
  photo.camera.k2_sigma = 0.03;
  photo.camera.version = 7;
  photo.attitude = GimbalAttitude{-131.3, -89.9, 0.1};
  photo.height_above_ground_m = 39.8 + i;
  return photo;
}

inline GnssFix fullFix(int i) {
  GnssFix fix;
  fix.time = 1466699519 * kNsPerSecond + TimeNs{i} * 2'123'456'700;
  fix.latitude_deg = 46.842864611111111 + i * 1e-10;
  fix.longitude_deg = -91.993696666666667;
  fix.height_m = 198.309;
  fix.sigma_enu_m = {0.0123, 0.0145, 0.0331};
  fix.datum = HeightDatum::kEllipsoid;
  return fix;
}

}  // namespace cf::support
