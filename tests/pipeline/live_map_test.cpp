// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// What is to be seen while the UAVs fly.
#include <gtest/gtest.h>

#include <algorithm>

#include "cf/base/log.h"
#include "cf/config/config.h"
#include "cf/pipeline/flight_run.h"
#include "live_picture.h"
#include "support/synthetic_flight.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

/// A photo of 400 x 200 m, from 200 m above level ground, its top to the north.
DenseView viewAt(std::uint16_t uav, std::uint32_t index, double east, double north) {
  DenseView view;
  view.id = {uav, index};
  view.T_world_cam.linear() = Eigen::Vector3d(1, -1, -1).asDiagonal();
  view.T_world_cam.translation() = Eigen::Vector3d(east, north, 250);
  view.camera.width = 1000;
  view.camera.height = 500;
  view.camera.fx = view.camera.fy = 500;
  view.camera.cx = 499.5;
  view.camera.cy = 249.5;
  view.median_depth_m = 200;
  return view;
}

TEST(CoveragePicture, CountsThePhotosOfEachPlace) {
  // From west -200 to east 400, south -100 to north 200.
  const std::vector<DenseView> views = {viewAt(0, 0, 0, 0), viewAt(0, 1, 200, 0),
                                        viewAt(1, 0, 0, 100)};
  const cv::Mat picture = coveragePicture(views, 0);
  ASSERT_FALSE(picture.empty());
  EXPECT_NEAR(static_cast<double>(picture.cols) / picture.rows, 2.0, 0.01);
  const auto at = [&](double east, double north) {
    return picture.at<cv::Vec3b>(static_cast<int>((200 - north) / 300 * picture.rows),
                                 static_cast<int>((east + 200) / 600 * picture.cols));
  };
  const cv::Vec3b one = at(-150, -80), two = at(-150, 50), three = at(100, 30), none = at(350, 150);
  EXPECT_EQ(at(300, -50), one);
  EXPECT_EQ(at(100, -50), two);
  EXPECT_GT(one[2], 180);     // red
  EXPECT_GT(two[2], two[1]);  // orange
  EXPECT_GT(three[1], 180);   // yellow
  EXPECT_EQ(none, cv::Vec3b(40, 40, 40));
  EXPECT_TRUE(coveragePicture({}, 0).empty());
}

TEST(LiveMapPicture, ShowsTheUppermostPointsNorthUp) {
  Tile tile;
  tile.offset_m = {100, 200, 0};
  const auto add = [&](float x, float y, float z, std::uint8_t blue) {
    TilePoint p;
    p.position_m = {x, y, z};
    p.bgr[0] = blue;
    tile.points.push_back(p);
  };
  add(0.5F, 0.5F, 5, 10);
  add(0.5F, 0.5F, 9, 20);  // above it
  add(0.5F, 0.5F, 7, 30);
  add(9.5F, 0.5F, 0, 40);
  add(0.5F, 19.5F, 0, 50);
  const cv::Mat picture = liveMapPicture({tile}, 1.0, {}, 0);
  ASSERT_EQ(picture.size(), cv::Size(10, 20));
  EXPECT_EQ(picture.at<cv::Vec3b>(19, 0)[0], 20);
  EXPECT_EQ(picture.at<cv::Vec3b>(0, 0)[0], 50);
  EXPECT_EQ(picture.at<cv::Vec3b>(19, 9)[0], 40);
  EXPECT_TRUE(liveMapPicture({}, 1.0, {}, 0).empty());
}

class LiveRun : public ::testing::Test {
 protected:
  RunRecord play(const fs::path& outdir, const std::vector<std::string>& settings) {
    setLogQuiet(true);
    Config config = Config::fromFile(support::writeSyntheticFlight(folder_ / "in"));
    for (const char* s : {"view.snapshots=false", "densify.megapixels=0.1", "align.update_every=3",
                          "deliver.dsm=0", "deliver.orthophoto=0"})
      config.override(s);
    for (const std::string& s : settings) config.override(s);
    return runFlight(config, {outdir, false, "test"});
  }
  support::TempFolder folder_;
};

TEST_F(LiveRun, WatchingChangesNothingOfTheResult) {
  play(folder_ / "unseen", {});
  EXPECT_FALSE(fs::exists(folder_ / "unseen/live"));
  play(folder_ / "seen", {"view.live_every_s=0.01"});
  EXPECT_TRUE(fs::exists(folder_ / "seen/live/map.png"));
  EXPECT_TRUE(fs::exists(folder_ / "seen/live/coverage.png"));
  for (const char* file : {"cloud/cloud.ply", "trajectories/northA.tum", "octomap.ot"})
    EXPECT_TRUE(support::fileText(folder_ / "unseen" / file) ==
                support::fileText(folder_ / "seen" / file))
        << file;
}

TEST_F(LiveRun, InRealTimeEveryPhotoHasALatency) {
  const RunRecord run = play(folder_ / "out", {"playback.rate=2", "playback.max_lag_s=600"});
  ASSERT_EQ(run.latencies.size(), 15u);
  ASSERT_TRUE(run.real_time);
  EXPECT_EQ(run.real_time->left_out_live, 0u);
  EXPECT_GE(run.real_time->most_behind_s, 0);
  // Each photo's latency is positive, and not counted from the start of the flight.
  for (const PhotoLatency& latency : run.latencies) EXPECT_GT(latency.latency_s, 0);
  for (const Warning& warning : run.warnings)
    EXPECT_EQ(warning.text.find("live map left out"), std::string::npos) << warning.text;
}

}  // namespace
}  // namespace cf
