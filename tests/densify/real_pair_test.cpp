// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <utility>

#include "cf/densify/densify.h"
#include "cf/formats/depth_frame_file.h"
#include "cf/formats/ply.h"
#include "cf/formats/tum.h"
#include "cf/geometry/depth_triangulation.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

/// A real flight with the poses, camera and cloud of an offline reconstruction.
struct Flight {
  fs::path folder;
  std::vector<std::string> names;
  std::vector<DenseView> views;
  std::vector<Eigen::Vector3d> cloud;
  std::map<std::pair<int, int>, std::vector<Eigen::Vector3d>> cells;  // of 1 m, of the cloud

  explicit Flight(const fs::path& where) : folder(where) {
    std::string line;
    for (std::ifstream in(folder / "reference/images.tsv"); std::getline(in, line);) {
      names.push_back(line.substr(0, line.find('\t')));
    }
    CameraModel camera;
    for (std::ifstream in(folder / "reference/camera.txt"); std::getline(in, line);) {
      if (line.empty() || line[0] == '#') continue;
      std::istringstream fields(line);  // 1 OPENCV width height fx fy cx cy k1 k2 p1 p2
      std::string id, model;
      fields >> id >> model >> camera.width >> camera.height >> camera.fx >> camera.fy >>
          camera.cx >> camera.cy >> camera.k1 >> camera.k2 >> camera.p1 >> camera.p2;
      camera.cx -= 0.5;  // there the pixel (0,0) is the corner
      camera.cy -= 0.5;
    }
    for (const PlyPoint& p : readPly(folder / "reference/cloud.ply")) {
      cloud.push_back(p.position_m);
      cells[cellOf(p.position_m)].push_back(p.position_m);
    }
    for (const TimedPose& pose : readTum(folder / "reference/poses.tum")) {
      DenseView view;
      view.id = {0, static_cast<std::uint32_t>(views.size())};
      view.T_world_cam = pose.T_world_cam;
      view.camera = camera;
      std::vector<double> depths;
      for (std::size_t k = 0; k < cloud.size(); k += 17) {
        const Eigen::Vector3d p = pose.T_world_cam.inverse() * cloud[k];
        if (p.z() > 1 && p.head<2>().norm() < p.z() && camera.contains(camera.project(p))) {
          depths.push_back(p.z());
        }
      }
      std::sort(depths.begin(), depths.end());
      if (depths.size() > 20) {
        view.near_depth_m = depths[depths.size() / 20];
        view.median_depth_m = depths[depths.size() / 2];
        view.far_depth_m = depths[depths.size() * 19 / 20];
      }
      views.push_back(view);
    }
  }

  static std::pair<int, int> cellOf(const Eigen::Vector3d& p) {
    return {static_cast<int>(std::floor(p.x())), static_cast<int>(std::floor(p.y()))};
  }
  /// Distance to the cloud; negative where it has no point within 0.5 m horizontally.
  double distance(const Eigen::Vector3d& p) const {
    double nearest = 1e9, beside = 1e9;
    const auto [x, y] = cellOf(p);
    for (int i = x - 1; i <= x + 1; ++i) {
      for (int j = y - 1; j <= y + 1; ++j) {
        const auto cell = cells.find({i, j});
        if (cell == cells.end()) continue;
        for (const Eigen::Vector3d& q : cell->second) {
          nearest = std::min(nearest, (p - q).norm());
          beside = std::min(beside, (p - q).head<2>().norm());
        }
      }
    }
    return beside < 0.5 ? nearest : -1;
  }
};

struct Wanted {
  const char* flight;
  std::uint32_t first, step;  // of the reference photos
  double half_metre, metre;   // shares of the points
  double coverage;            // matched share of the views
};

class RealPair : public testing::TestWithParam<Wanted> {};

TEST_P(RealPair, agreesWithTheOfflineReconstruction) {
  const Wanted wanted = GetParam();
  const fs::path folder = fs::path(CF_REAL_DATA) / wanted.flight;
  if (!fs::exists(folder)) GTEST_SKIP() << "no real data: " << folder.string() << " is missing";
  const Flight flight(folder);
  double compared = 0, half_metre = 0, metre = 0, matched = 0, pixels = 0;
  for (std::uint32_t k = wanted.first; k < flight.views.size(); k += wanted.step) {
    const DenseView& reference = flight.views[k];
    const auto image = [&](std::uint32_t i) {
      return cv::imread((folder / "images" / flight.names[i]).string());
    };
    const auto partners = choosePartners(reference, flight.views, {});
    ASSERT_FALSE(partners.empty()) << flight.names[k];
    const DenseView& partner = flight.views[partners[0].index];
    const auto frame = matchPair(reference, image(k), partner, image(partners[0].index), {});
    ASSERT_TRUE(frame.ok()) << flight.names[k] << ": " << frame.failure().detail;
    EXPECT_LT(encodeDepthFrame(*frame).size(), 3'000'000U);
    DepthTriangulationOptions options;
    options.stride = 4;
    const MapPoints points = triangulateDepth(*frame, {reference.T_world_cam, reference.camera},
                                              {partner.T_world_cam, partner.camera}, options);
    for (const MapPoint& point : points.points) {
      ++matched;
      const double distance = flight.distance(points.world(point));
      if (distance < 0) continue;
      ++compared;
      half_metre += distance < 0.5;
      metre += distance < 1;
    }
    pixels += static_cast<double>(frame->disparity.total()) / 16;
  }
  std::printf("%s: %.0f points, %.2f %% within 0.5 m, %.2f %% within 1 m, %.1f %% matched\n",
              wanted.flight, compared, 100 * half_metre / compared, 100 * metre / compared,
              100 * matched / pixels);
  EXPECT_GT(compared, 10'000);
  EXPECT_GT(half_metre / compared, wanted.half_metre);
  EXPECT_GT(metre / compared, wanted.metre);
  EXPECT_GT(matched / pixels, wanted.coverage);
}

INSTANTIATE_TEST_SUITE_P(Flights, RealPair,
                         testing::Values(Wanted{"brighton_beach", 1, 6, 0.95, 0.96, 0.25},
                                         Wanted{"sheffield_cross", 10, 40, 0.92, 0.97, 0.55}),
                         [](const auto& flight) { return std::string(flight.param.flight); });

}  // namespace
}  // namespace cf
