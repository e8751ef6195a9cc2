// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// A whole run on a small flight of three UAVs whose truth is exact.
#include "cf/pipeline/flight_run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

#include "cf/base/log.h"
#include "cf/config/config.h"
#include "cf/formats/float_raster.h"
#include "cf/formats/ply.h"
#include "cf/formats/tum.h"
#include "cf/geometry/similarity.h"
#include "support/synthetic_flight.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

namespace fs = std::filesystem;
using support::SyntheticFlight;

struct Positions {
  std::vector<Eigen::Vector3d> estimate, truth;
};

Positions positionsOf(const RunRecord& run) {
  Positions p;
  for (std::size_t u = 0; u < run.uavs.size(); ++u)
    for (const PhotoPose& pose : run.uavs[u].final_trajectory) {
      p.estimate.push_back(pose.T_world_cam.translation());
      p.truth.push_back(
          support::syntheticFlight().uavs[u].photos[pose.photo].truth.T_world_cam.translation());
    }
  return p;
}

double rms(const Positions& p, const Sim3& S_truth_est) {
  double sum = 0;
  for (std::size_t i = 0; i < p.truth.size(); ++i)
    sum += (p.truth[i] - S_truth_est * p.estimate[i]).squaredNorm();
  return std::sqrt(sum / static_cast<double>(p.truth.size()));
}

/// Share of the cloud's points that lie within `limit_m` of the true ground or roof, those near
/// the walls left out.
struct Surface {
  double share_within = 0;
  std::size_t points = 0;
};
Surface surfaceOf(const fs::path& ply, const Sim3& S_truth_est, double limit_m) {
  const support::HouseScene& scene = support::syntheticFlight().scene;
  Surface s;
  std::size_t good = 0;
  for (const PlyPoint& p : readPly(ply)) {
    const Eigen::Vector3d truth = S_truth_est * p.position_m;
    const double x = truth.x(), y = truth.y();
    if (std::abs(scene.distanceToWall(x, y)) < 1) continue;
    ++s.points;
    if (std::abs(truth.z() - scene.height(x, y)) < limit_m) ++good;
  }
  s.share_within = static_cast<double>(good) / static_cast<double>(s.points);
  return s;
}

/// Of every depth on the photo's pixels: share of surface points within `limit_m` of the scene.
Surface surfaceOfDepthMaps(const RunRecord& run, const fs::path& folder, const Sim3& S_truth_est,
                           double limit_m) {
  const support::HouseScene& scene = support::syntheticFlight().scene;
  Surface s;
  std::size_t good = 0;
  for (const UavRecord& uav : run.uavs)
    for (const PhotoPose& pose : uav.final_trajectory) {
      const std::string stem = fs::path(uav.photos[pose.photo].name).stem().string();
      const fs::path file = folder / uav.name / (stem + ".tif");
      if (!fs::exists(file)) continue;
      const FloatRaster map = readFloatRaster(file);
      const int step = std::stoi(map.metadata.at("STEP"));
      for (int j = 0; j < map.values.rows; ++j)
        for (int i = 0; i < map.values.cols; ++i) {
          const double depth = static_cast<double>(map.values.at<float>(j, i));
          if (depth <= 0) continue;
          const Eigen::Vector2d pixel(i * step, j * step);
          const Eigen::Vector3d p =
              S_truth_est *
              (pose.T_world_cam *
               Eigen::Vector3d(depth * uav.camera_after.undistort(pixel).homogeneous()));
          if (std::abs(scene.distanceToWall(p.x(), p.y())) < 1) continue;
          ++s.points;
          if (std::abs(p.z() - scene.height(p.x(), p.y())) < limit_m) ++good;
        }
    }
  s.share_within = static_cast<double>(good) / static_cast<double>(s.points);
  return s;
}

class FlightRun : public ::testing::Test {
 protected:
  static RunRecord play(const fs::path& ini, const fs::path& outdir,
                        const std::vector<std::string>& settings) {
    setLogQuiet(true);
    Config config = Config::fromFile(ini);
    config.override("view.snapshots=false");
    for (const std::string& s : settings) config.override(s);
    return runFlight(config, {outdir, false, "test"});
  }
  support::TempFolder folder_;
};

TEST_F(FlightRun, PosesAndSurfaceAreTheTruth) {
  const fs::path ini = support::writeSyntheticFlight(folder_ / "in");
  const RunRecord run = play(ini, folder_ / "out",
                             {std::string("world.origin=") + SyntheticFlight::originText(),
                              "deliver.depth_maps=1", "deliver.html=0"});
  EXPECT_EQ(run.components, 1);
  EXPECT_GT(run.relative_poses.size(), 5u);
  ASSERT_EQ(run.uavs.size(), 3u);
  for (const UavRecord& uav : run.uavs) {
    EXPECT_EQ(uav.final_trajectory.size(), 5u) << uav.name;
    EXPECT_TRUE(uav.gnss.trusted) << uav.name;
    EXPECT_NEAR(uav.camera_after.fx, 520, 3) << uav.name;
  }
  const Positions p = positionsOf(run);
  // Each UAV's own GNSS bias leaves the tilt across the lines to priors of a degree or two.
  EXPECT_LT(rms(p, Sim3()), 0.5);
  const auto se3 = alignPoints(p.truth, p.estimate, AlignmentModel::kSe3);
  const auto sim3 = alignPoints(p.truth, p.estimate, AlignmentModel::kSim3);
  ASSERT_TRUE(se3 && sim3);
  EXPECT_LT(rms(p, se3.value()), 0.08);
  EXPECT_LT(rms(p, sim3.value()), 0.06);
  EXPECT_NEAR(sim3.value().scale, 1, 0.004);

  const Surface surface = surfaceOf(folder_ / "out/cloud/cloud.ply", se3.value(), 0.15);
  EXPECT_GT(surface.points, 500'000u);
  EXPECT_GT(surface.share_within, 0.95);

  const Surface depth = surfaceOfDepthMaps(run, folder_ / "out/depth", se3.value(), 0.15);
  EXPECT_GT(depth.points, 1'000'000u);
  EXPECT_GT(depth.share_within, 0.95);
  EXPECT_FALSE(fs::exists(folder_ / "out/report.html"));
  for (const UavRecord& uav : run.uavs)
    EXPECT_EQ(readTum(folder_ / "out/odometry" / (uav.name + ".tum")).size(), 5u);
}

TEST_F(FlightRun, WithoutGnssTheMapIsRelative) {
  const fs::path ini = support::writeSyntheticFlight(folder_ / "in", false);
  const RunRecord run = play(ini, folder_ / "out", {});
  EXPECT_TRUE(run.world.relative);
  EXPECT_EQ(run.components, 1);
  const Positions p = positionsOf(run);
  ASSERT_EQ(p.truth.size(), 15u);
  const auto S = alignPoints(p.truth, p.estimate, AlignmentModel::kSim3);
  ASSERT_TRUE(S);
  EXPECT_LT(rms(p, S.value()), 0.1);
  EXPECT_TRUE(fs::exists(folder_ / "out/cloud/cloud.ply"));
  EXPECT_FALSE(fs::exists(folder_ / "out/trajectories/all.kml"));
}

TEST_F(FlightRun, TheSameBytesAgainAndWithAnyNumberOfThreads) {
  const fs::path ini = support::writeSyntheticFlight(folder_ / "in");
  const std::string small = "densify.megapixels=0.1";
  play(ini, folder_ / "one", {small, "system.threads=1"});
  for (const char* again : {"1", "2", "2"}) {
    play(ini, folder_ / "again", {small, std::string("system.threads=") + again});
    for (const char* file :
         {"trajectories/northA.tum", "trajectories/northB.tum", "trajectories/northC.tum",
          "trajectories/northA.online.tum", "trajectories/northC.online.tum", "cameras/northB.ini",
          "relative_poses.csv", "cloud/sparse.ply", "cloud/cloud.ply", "octomap.ot",
          "images/northA.csv", "graphs/northC.graph", "scale/northB.csv"})
      EXPECT_TRUE(support::fileText(folder_ / "one" / file) ==
                  support::fileText(folder_ / "again" / file))
          << file << " with " << again << " threads";
    fs::remove_all(folder_ / "again");
  }
}

}  // namespace
}  // namespace cf
