// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "cf/base/log.h"
#include "cf/deliver/run_record.h"

namespace cf {

namespace fs = std::filesystem;

inline constexpr TimeNs kStart = 1466699519'123456789;

inline Eigen::Isometry3d poseAt(double x, double y, double z) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = (Eigen::AngleAxisd(0.3 + 0.01 * x, Eigen::Vector3d::UnitZ()) *
                Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()))
                   .toRotationMatrix();
  T.translation() << x, y, z;
  return T;
}

inline UavRecord makeUav(const std::string& name, double north) {
  UavRecord uav;
  uav.name = name;
  for (int i = 0; i < 4; ++i) {
    PhotoRecord photo;
    photo.name = "DJI_000" + std::to_string(i) + ".JPG";
    photo.time = kStart + i * kNsPerSecond;
    photo.status = PhotoStatus::kPosed;
    photo.segment = 0;
    photo.keypoints = 2000 + i;
    photo.matches = 500 + i;
    photo.inliers = 300 + i;
    uav.photos.push_back(photo);
  }
  uav.photos[2].status = PhotoStatus::kDamaged;
  uav.photos[2].segment = -1;
  uav.photos[2].reason = "cannot be decoded: truncated, \"premature end\"";
  for (const std::uint32_t i : {0U, 1U, 3U}) {
    uav.final_trajectory.push_back({i, poseAt(8.0 * i + 0.123456, north, 60)});
    uav.online_trajectory.push_back({i, poseAt(8.0 * i + 1, north, 61)});
  }
  CameraModel camera;
  camera.width = 4000;
  camera.height = 3000;
  camera.fx = camera.fy = 2300.25;
  camera.cx = 1999.5;
  camera.cy = 1499.5;
  camera.focal_sigma = 115;
  uav.camera_before = camera;
  camera.fx = camera.fy = 2345.678901;
  camera.k1 = -0.0123456789;
  camera.focal_sigma = 3.5;
  uav.camera_after = camera;
  uav.scale_history = {{kStart, 0, 11.0, 2.0}, {kStart + 3 * kNsPerSecond, 0, 12.5, 0.25}};
  uav.gnss.sigma_m = {0.5, 0.6, 1.5};
  uav.gnss.bias_m = {0.1, -0.2, 3.0};
  uav.gnss.trusted = true;
  uav.segments = 1;
  uav.pose_graph = "VERTEX3 0 1 2 3 0 0 0\n";
  return uav;
}

inline RunRecord makeRun() {
  RunRecord run;
  run.version = "0.1.0";
  run.world.latitude_deg = 46.8426070833333;
  run.world.longitude_deg = -91.9945598888889;
  run.world.height_m = 198.309;
  run.world.h_datum = HeightDatum::kEllipsoid;
  run.world.utm = "15N";
  run.world.center = "east";
  run.uavs = {makeUav("east", 0), makeUav("west & <2>", 20)};
  RelativePose r;
  r.a = {0, 1};
  r.b = {1, 3};
  r.inliers = 77;
  r.T_a_b = poseAt(1.25, -2.5, 0.75);
  r.sigma << 0.1, 0.2, 0.3, 0.01, 0.02, 0.03;
  r.residual_before = 2.5;
  r.residual_after = 0.05;
  run.relative_poses = {r};
  SparsePoint point;
  point.position_m = {1.5, 2.5, -60};
  point.bgr[0] = 10;
  point.bgr[1] = 20;
  point.bgr[2] = 30;
  run.sparse_points = {point};
  run.stages["odometry"] = {4.0, 8.0};
  for (std::uint32_t i = 100; i >= 1; --i) run.latencies.push_back({{0, i}, 0, 0.01 * i});
  run.bytes_over_seam = 123456789012;
  run.wall_s = 12.5;
  run.peak_rss_mb = 800;
  run.components = 1;
  run.warnings = {Warning("a warning with <angle> brackets", "an <advice>")};
  return run;
}

inline std::string textOf(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

inline std::string firstLine(const fs::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  if (!line.empty() && line.back() == '\r') line.pop_back();
  return line;
}

/// Every tag closed in order; attributes and text free of raw < and &.
inline bool wellFormed(const std::string& xml, std::set<std::string> void_tags = {}) {
  std::vector<std::string> open;
  for (std::size_t i = 0; i < xml.size(); ++i) {
    if (xml[i] == '&') {
      const auto end = xml.find(';', i);
      if (end == std::string::npos || end - i > 6) return false;
    }
    if (xml[i] != '<') continue;
    const auto end = xml.find('>', i);
    if (end == std::string::npos) return false;
    const std::string tag = xml.substr(i + 1, end - i - 1);
    if (tag.empty() || tag.find('<') != std::string::npos) return false;
    i = end;
    if (tag.front() == '?' || tag.front() == '!' || tag.back() == '/') continue;
    const std::string name = tag.substr(0, tag.find_first_of(" \n"));
    if (void_tags.count(name)) continue;
    if (tag.front() != '/') {
      open.push_back(name);
    } else {
      if (open.empty() || "/" + open.back() != name) return false;
      open.pop_back();
    }
  }
  return open.empty();
}

class Deliver : public ::testing::Test {
 protected:
  void SetUp() override {
    setLogQuiet(true);
    dir_ = fs::temp_directory_path() / ("cf_deliver_" + std::to_string(getpid()));
    fs::remove_all(dir_);
  }
  void TearDown() override { fs::remove_all(dir_); }
  fs::path dir_;
};

}  // namespace cf
