// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <random>
#include <vector>

#include "cf/deliver/run_record.h"
#include "support/views.h"

namespace cf::support {

/// The record of a good flight of two UAVs over rolling ground, made without photos: what is wrong
/// with it is up to the test.
struct RecordedFlight {
  double pixel_sigma = 0.3;
  double fix_sigma_m = 1;  ///< of the fixes; they tag 1 m
  double bend_m = 0;       ///< of the map against the fixes: lower by so much at the corners
  CameraModel seen_by;     ///< that took the photos; the map has camera()
  Eigen::Vector3d seam_m = Eigen::Vector3d::Zero();  ///< between the UAVs
  int rows = 30;                                     ///< of ground points, and columns
  unsigned seed = 7;

  RecordedFlight() : seen_by(camera()) {}

  static CameraModel camera() {
    CameraModel c;
    c.width = 4000;
    c.height = 3000;
    c.fx = c.fy = 3000;
    c.cx = 1999.5;
    c.cy = 1499.5;
    return c;
  }

  RunRecord record() const {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    RunRecord run;
    run.version = "0";
    run.world.latitude_deg = 46.9;
    run.world.longitude_deg = 7.4;
    run.world.height_m = 500;
    run.world.h_datum = HeightDatum::kEllipsoid;
    run.world.utm = "32N";
    run.world.center = "a";
    run.components = 1;
    for (const char* uav : {"a", "b"}) addUav(uav, random, run);
    for (int i = 0; i < rows * rows; ++i)
      addPoint({-100 + 200.0 * (i % rows) / (rows - 1), -100 + 200.0 * (i / rows) / (rows - 1),
                2 * std::sin(0.4 * i)},
               random, run);
    for (int i = 0; i < 6000; ++i) {
      const Eigen::Vector3d noise(0.05 * normal(random), 0.05 * normal(random),
                                  0.1 * normal(random));
      run.seam_points.push_back({0,
                                 1,
                                 {-100 + 200.0 * (i % 80) / 79, -100 + 200.0 * (i / 80) / 75, 0.0},
                                 seam_m + (i % 7 == 0 ? 40 : 1) * noise});
    }
    Tile tile;
    for (int i = 0; i < 2000; ++i) {
      TilePoint p;
      p.position_m = {static_cast<float>(i % 50), static_cast<float>(i) / 50, 0.01f * (i % 7)};
      p.views = i % 10 == 0 ? 1 : 3;
      tile.points.push_back(p);
    }
    run.cloud.add(tile);
    return run;
  }

 private:
  void addUav(const char* name, std::mt19937& random, RunRecord& run) const {
    std::normal_distribution<double> normal;
    UavRecord& uav = run.uavs.emplace_back();
    uav.name = name;
    uav.camera_before = uav.camera_after = camera();
    uav.segments = 1;
    uav.gnss.trusted = true;
    for (std::uint32_t i = 0; i < 60; ++i) {
      const double x = -100 + 200.0 * (i % 10) / 9, y = -100 + 200.0 * (i / 10) / 5;
      PhotoRecord photo;
      photo.name = std::to_string(i) + ".jpg";
      photo.time = (1000 + 2 * i) * kNsPerSecond;
      photo.status = PhotoStatus::kPosed;
      photo.segment = 0;
      uav.photos.push_back(photo);
      const Eigen::Vector3d centre(x, y, 80);
      uav.final_trajectory.push_back({i, nadirPose(centre, 90)});
      GnssPosition fix;
      fix.position_m =
          centre + fix_sigma_m * Eigen::Vector3d(normal(random), normal(random), normal(random));
      fix.position_m.z() += bend_m * (x * x + y * y) / 20'000;
      uav.fixes[i] = fix;
      ++uav.gnss.fixes;
      PhotoCovariance known;
      known.covariance.in_map.diagonal().setConstant(1e-6);
      uav.covariances[i] = known;
      uav.scale_history.push_back({photo.time, 0, 10 + 1.0 / (i + 1), 1.0 / (i + 1)});
      run.latencies.push_back({{static_cast<std::uint16_t>(run.uavs.size() - 1), i}, 1.0 * i, 0.5});
    }
  }

  void addPoint(const Eigen::Vector3d& p, std::mt19937& random, RunRecord& run) const {
    std::normal_distribution<double> normal(0, pixel_sigma);
    SparsePoint point;
    point.position_m = p;
    for (std::uint16_t u = 0; u < run.uavs.size(); ++u)
      for (const PhotoPose& pose : run.uavs[u].final_trajectory) {
        const Eigen::Vector3d q = pose.T_world_cam.inverse() * p;
        const Eigen::Vector2d pixel = seen_by.project(q);
        if (q.z() <= 0 || !seen_by.contains(pixel)) continue;
        point.observations.push_back({{u, pose.photo}, 0});
        run.sparse_pixels.emplace_back(static_cast<float>(pixel.x() + normal(random)),
                                       static_cast<float>(pixel.y() + normal(random)));
      }
    run.sparse_points.push_back(point);
  }
};

}  // namespace cf::support
