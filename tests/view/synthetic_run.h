// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/ColorOcTree.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "cf/formats/csv.h"
#include "cf/formats/ply.h"
#include "cf/formats/tum.h"

namespace cf::testing {

using Rgb = std::array<std::uint8_t, 3>;
inline constexpr Rgb kGround = {110, 110, 110};
inline constexpr Rgb kNorthEast = {60, 160, 60};  // quarter of the ground
inline constexpr Rgb kBox = {40, 60, 200};

/// An output folder with a grey plane z = 0 of 40 m x 30 m around the origin, its north-east
/// quarter green, a blue box 6 m x 6 m x 5 m in its middle; UAV "a" (central) flies east at y = -8,
/// z = 20, "b" at y = +8, and one relative pose joins their third photos (x = 0).
class SyntheticRun {
 public:
  SyntheticRun() {
    namespace fs = std::filesystem;
    dir_ = fs::temp_directory_path() / ("cf_view_" + std::to_string(getpid()));
    fs::remove_all(dir_);
    for (const char* d : {"cloud", "trajectories", "images"}) fs::create_directories(dir_ / d);
    writeCloudAndOctomap();
    writeTrack("a", -8);
    writeTrack("b", 8);
    CsvWriter links(dir_ / "relative_poses.csv",
                    {"uav_a", "uav_b", "image_a", "image_b", "inliers"});
    links.row({"a", "b", "a2.jpg", "b2.jpg", "100"});
    links.close();
    writeFileAtomically(dir_ / "world.json",
                        R"({"origin":{"lat":46,"lon":-92,"h":100},"h_datum":"ellipsoid",)"
                        R"("frame":"ENU","utm":"15N","center":"a"})");
  }
  ~SyntheticRun() { std::filesystem::remove_all(dir_); }
  const std::filesystem::path& dir() const { return dir_; }

 private:
  void writeCloudAndOctomap() {
    PlyWriter ply(dir_ / "cloud/cloud.ply");
    octomap::ColorOcTree tree(0.5);
    const auto add = [&](double x, double y, double z, const Rgb& rgb) {
      ply.add(Eigen::Vector3d(x, y, z).cast<float>(), rgb);
      const octomap::point3d p(static_cast<float>(x), static_cast<float>(y),
                               static_cast<float>(z) - 0.01F);
      tree.updateNode(p, true, true);
      tree.setNodeColor(tree.coordToKey(p), rgb[0], rgb[1], rgb[2]);
    };
    const double step = 0.2;
    for (int i = -100; i <= 100; ++i)
      for (int j = -75; j <= 75; ++j) {
        const double x = step * i, y = step * j;
        const bool box = std::abs(x) <= 3 && std::abs(y) <= 3;
        if (!box) add(x, y, 0, x > 0 && y > 0 ? kNorthEast : kGround);
        if (box) add(x, y, 5, kBox);
      }
    for (int i = -15; i <= 15; ++i)
      for (int k = 0; k <= 25; ++k)
        for (const double side : {-3.0, 3.0}) {
          add(step * i, side, step * k, kBox);
          add(side, step * i, step * k, kBox);
        }
    ply.close();
    tree.updateInnerOccupancy();
    tree.write((dir_ / "octomap.ot").string());
  }

  void writeTrack(const std::string& uav, double north) {
    std::vector<TimedPose> poses;
    CsvWriter images(
        dir_ / "images" / (uav + ".csv"),
        {"image", "t", "status", "segment", "keypoints", "matches", "inliers", "reason"});
    for (int i = 0; i < 5; ++i) {
      TimedPose pose;
      pose.time = (1000 + i) * kNsPerSecond;
      pose.T_world_cam.translation() << -12 + 6 * i, north, 20;
      poses.push_back(pose);
      images.row(
          {uav + std::to_string(i) + ".jpg", timeText(pose.time), "posed", "0", "1", "1", "1", ""});
    }
    images.close();
    writeTum(dir_ / "trajectories" / (uav + ".tum"), poses);
    writeTum(dir_ / "trajectories" / (uav + ".online.tum"), poses);
  }

  std::filesystem::path dir_;
};

}  // namespace cf::testing
