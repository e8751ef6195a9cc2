// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <mrpt/opengl/COpenGLScene.h>
#include <mrpt/opengl/CPointCloudColoured.h>
#include <sys/wait.h>

#include <cmath>
#include <cstdlib>
#include <opencv2/imgcodecs.hpp>

#include "cf/base/error.h"
#include "cf/view/render.h"
#include "support/temp_folder.h"
#include "view/synthetic_run.h"

namespace cf {
namespace {

namespace fs = std::filesystem;
using testing::kBox;
using testing::kGround;
using testing::kNorthEast;
using testing::Rgb;

constexpr ImageSize kSize{960, 540};

class Snapshot : public ::testing::Test {
 protected:
  cv::Mat render(const std::string& view) {
    SceneLimits limits;
    limits.with_voxels = true;
    scene_ = loadScene(run_.dir(), limits);
    camera_ = frameScene(scene_, parseView(view), kSize);
    const fs::path png = run_.dir() / "picture.png";
    renderSnapshot(scene_, parseView(view), kSize, png);
    const cv::Mat picture = cv::imread(png.string());
    EXPECT_EQ(picture.cols, kSize.width);
    EXPECT_EQ(picture.rows, kSize.height);
    return picture;
  }

  // Parallel projection from above, north up, written out.
  cv::Point fromAbove(double east, double north) const {
    const double px = kSize.height / camera_.height_m;
    return {cvRound((kSize.width - 1) / 2.0 + (east - camera_.target_m.x()) * px),
            cvRound((kSize.height - 1) / 2.0 - (north - camera_.target_m.y()) * px)};
  }
  cv::Point seen(double x, double y, double z) const {
    const Eigen::Vector2d p = camera_.project({x, y, z});
    return {cvRound(p.x()), cvRound(p.y())};
  }

  testing::SyntheticRun run_;
  SceneInputs scene_;
  ViewCamera camera_;
};

::testing::AssertionResult is(const cv::Mat& picture, cv::Point p, const Rgb& rgb, int within = 6) {
  if (!cv::Rect(0, 0, picture.cols, picture.rows).contains(p))
    return ::testing::AssertionFailure() << p << " is outside the picture";
  const auto c = picture.at<cv::Vec3b>(p);
  const Rgb got = {c[2], c[1], c[0]};
  for (std::size_t k = 0; k < 3; ++k)
    if (std::abs(got[k] - rgb[k]) > within)
      return ::testing::AssertionFailure()
             << "at " << p << ": " << int{got[0]} << " " << int{got[1]} << " " << int{got[2]}
             << ", not " << int{rgb[0]} << " " << int{rgb[1]} << " " << int{rgb[2]};
  return ::testing::AssertionSuccess();
}

TEST_F(Snapshot, TopShowsTheGroundWhereItIs) {
  const cv::Mat picture = render("top");
  EXPECT_TRUE(camera_.orthographic);
  EXPECT_TRUE(is(picture, fromAbove(0.8, 0.9), kBox));
  EXPECT_TRUE(is(picture, fromAbove(-2.5, 2.0), kBox));
  EXPECT_TRUE(is(picture, fromAbove(12, 12), kNorthEast));  // north is up, east is right
  EXPECT_TRUE(is(picture, fromAbove(15, 4), kNorthEast));
  EXPECT_TRUE(is(picture, fromAbove(-12, 12), kGround));
  EXPECT_TRUE(is(picture, fromAbove(12, -12), kGround));
  EXPECT_TRUE(is(picture, fromAbove(-15, -4), kGround));
  // The edge of the green quarter lies where it should to a quarter of a metre.
  EXPECT_TRUE(is(picture, fromAbove(0.45, 12), kNorthEast));
  EXPECT_TRUE(is(picture, fromAbove(-0.25, 12), kGround));
  EXPECT_TRUE(is(picture, {5, 300}, {30, 30, 30}));
}

TEST_F(Snapshot, TopShowsTrajectoriesAndRelativePoses) {
  const cv::Mat picture = render("top");
  const auto b = uavColour(false, 0);
  EXPECT_TRUE(is(picture, fromAbove(-9, -8), {255, 255, 255}));  // central: white
  EXPECT_TRUE(is(picture, fromAbove(4, -8), {255, 255, 255}));
  EXPECT_TRUE(is(picture, fromAbove(-9, 8), {b[0], b[1], b[2]}));
  EXPECT_TRUE(is(picture, fromAbove(0, 4.5), {255, 30, 30}, 40));  // red, over the ground
  EXPECT_TRUE(is(picture, fromAbove(0, 0), {255, 30, 30}, 40));    // and over the box
  // The triangle at the end points on, in the direction of flight; there is none at the start.
  const cv::Point end = fromAbove(12, 8), start = fromAbove(-12, 8);
  EXPECT_TRUE(is(picture, {end.x + 8, end.y}, {b[0], b[1], b[2]}));
  EXPECT_TRUE(is(picture, {end.x - 2, end.y + 4}, {b[0], b[1], b[2]}));
  EXPECT_TRUE(is(picture, {start.x - 8, start.y}, kGround));
}

TEST_F(Snapshot, GroundIsASurfaceWithoutGaps) {
  const cv::Mat picture = render("top");
  int gaps = 0;
  for (double x = -19; x <= 19; x += 0.05)
    for (double y = -14; y <= -10; y += 0.05)
      if (is(picture, fromAbove(x, y), {30, 30, 30}, 3)) ++gaps;
  EXPECT_EQ(gaps, 0);
}

TEST_F(Snapshot, ObliqueViewHidesWhatTheBoxStandsBefore) {
  const cv::Mat picture = render("iso");
  EXPECT_FALSE(camera_.orthographic);
  EXPECT_TRUE(is(picture, seen(1, -1, 5), kBox, 12));
  EXPECT_TRUE(is(picture, seen(-10, -10, 0), kGround, 12));
  EXPECT_TRUE(is(picture, seen(15, 12, 0), kNorthEast, 12));
  // Ground right behind the box, as seen from the south-east: blue, not grey or green.
  const auto hidden = picture.at<cv::Vec3b>(seen(-1.5, 3.5, 0));
  EXPECT_GT(hidden[0], hidden[1] + 30);
  EXPECT_GT(hidden[0], hidden[2] + 30);
  EXPECT_TRUE(is(picture, seen(-9, -8, 20), {255, 255, 255}));
  EXPECT_TRUE(is(picture, seen(0, 2, 20), {255, 30, 30}, 60));
}

TEST_F(Snapshot, EveryViewHoldsTheWholeScene) {
  for (const char* view : {"top", "iso", "front", "octomap", "height", "uav:a"}) {
    SceneLimits limits;
    limits.with_voxels = true;
    scene_ = loadScene(run_.dir(), limits);
    camera_ = frameScene(scene_, parseView(view), kSize);
    for (const auto& p : {Eigen::Vector3d(-12, -8, 20), Eigen::Vector3d(12, -8, 20),
                          Eigen::Vector3d(-10, -14, 0), Eigen::Vector3d(10, -14, 0)}) {
      const Eigen::Vector2d px = camera_.project(p);
      EXPECT_GT(px.x(), 0) << view;
      EXPECT_GT(px.y(), 0) << view;
      EXPECT_LT(px.x(), kSize.width - 1) << view;
      EXPECT_LT(px.y(), kSize.height - 1) << view;
      EXPECT_GT(camera_.depth(p), camera_.near_m) << view;
      EXPECT_LT(camera_.depth(p), camera_.far_m) << view;
    }
  }
}

TEST_F(Snapshot, HeightIsColouredFromLowToHigh) {
  const cv::Mat picture = render("height");
  EXPECT_TRUE(is(picture, fromAbove(-12, -12), {68, 1, 84}, 8));  // viridis' lower end
  EXPECT_TRUE(is(picture, fromAbove(1, 1), {253, 231, 37}, 8));   // and its upper end
  EXPECT_TRUE(is(picture, fromAbove(-9, 8), {68, 1, 84}, 8));     // no trajectory in the way
}

TEST_F(Snapshot, OctomapShowsVoxelsInTheirColours) {
  const cv::Mat picture = render("octomap");
  EXPECT_TRUE(is(picture, seen(1, -1, 5), kBox, 12));
  EXPECT_TRUE(is(picture, seen(-10, -10, 0), kGround, 12));
  EXPECT_TRUE(is(picture, seen(15, 12, 0), kNorthEast, 12));
}

TEST_F(Snapshot, AlargeOctomapIsShownCoarser) {
  SceneLimits limits;
  limits.with_voxels = true;
  const auto fine = loadScene(run_.dir(), limits).voxels;
  limits.max_voxels = fine.size() / 2;
  const auto coarse = loadScene(run_.dir(), limits).voxels;
  EXPECT_LE(coarse.size(), limits.max_voxels);
  EXPECT_GT(coarse.size(), limits.max_voxels / 8);
  EXPECT_NEAR(static_cast<double>(coarse.front().size_m), 1.0, 1e-6);
}

TEST_F(Snapshot, AlargeCloudIsThinnedEvenly) {
  const auto all = loadScene(run_.dir()).cloud;
  SceneLimits limits;
  limits.max_points = all.size() / 4;
  const auto thin = loadScene(run_.dir(), limits).cloud;
  EXPECT_NEAR(static_cast<double>(thin.size()), static_cast<double>(limits.max_points),
              0.05 * static_cast<double>(limits.max_points));
  double mean_x = 0;
  for (const auto& p : thin) mean_x += static_cast<double>(p.position_m.x());
  EXPECT_NEAR(mean_x / static_cast<double>(thin.size()), 0, 0.5);
}

TEST_F(Snapshot, EachPhotoShowsItsStrongestPartnerOfEachOtherUav) {
  CsvWriter table(run_.dir() / "relative_poses.csv",
                  {"uav_a", "uav_b", "image_a", "image_b", "inliers"});
  table.row({"a", "b", "a2.jpg", "b2.jpg", "100"});
  table.row({"a", "b", "a2.jpg", "b1.jpg", "50"});
  table.row({"a", "b", "a1.jpg", "b2.jpg", "40"});
  table.row({"a", "b", "a1.jpg", "b1.jpg", "10"});  // both have a stronger one
  table.row({"a", "a", "a0.jpg", "a1.jpg", "500"});
  table.close();
  const auto links = loadScene(run_.dir()).links;
  ASSERT_EQ(links.size(), 3U);
  for (const auto& link : links) EXPECT_NEAR((link.a_m - link.b_m).y(), -16, 1e-6);
  EXPECT_NEAR(links[0].a_m.x(), links[0].b_m.x(), 1e-6);
  EXPECT_NE(links[1].a_m.x(), links[1].b_m.x());
  EXPECT_NE(links[2].a_m.x(), links[2].b_m.x());
}

TEST_F(Snapshot, TheSamePictureTwiceIsTheSameFile) {
  const cv::Mat first = render("iso"), second = render("iso");
  EXPECT_EQ(cv::norm(first, second, cv::NORM_INF), 0);
}

TEST_F(Snapshot, SceneFileOpensAgain) {
  const SceneInputs scene = loadScene(run_.dir());
  writeScene(scene, run_.dir() / "map.3Dscene");
  mrpt::opengl::COpenGLScene loaded;
  ASSERT_TRUE(loaded.loadFromFile((run_.dir() / "map.3Dscene").string()));
  const auto cloud = loaded.getByClass<mrpt::opengl::CPointCloudColoured>();
  ASSERT_TRUE(cloud);
  EXPECT_EQ(cloud->size(), scene.cloud.size());
}

TEST_F(Snapshot, ARunGetsAllItsPictures) {
  const auto files = renderRun(run_.dir(), {320, 200});
  ASSERT_EQ(files.size(), 8U);  // top iso front height octomap, a, b, scene
  for (const auto& file : files) EXPECT_GT(fs::file_size(file), 1000U) << file;
  EXPECT_TRUE(fs::exists(run_.dir() / "snapshots/uav_b.png"));
}

TEST_F(Snapshot, ARelativeMapHasNoNorthArrow) {
  const cv::Mat with = render("top");
  writeFileAtomically(run_.dir() / "world.json", R"({"origin":null,"frame":"local","center":"a"})");
  const cv::Mat without = render("top");
  const cv::Rect corner(kSize.width - 80, 8, 70, 70);
  EXPECT_TRUE(is(without(corner), {35, 35}, {30, 30, 30}));
  EXPECT_FALSE(is(with(corner), {35, 35}, {30, 30, 30}));
}

TEST_F(Snapshot, FaultsAreNamed) {
  EXPECT_THROW((void)parseView("side"), UsageError);
  EXPECT_THROW((void)parseView("uav:"), UsageError);
  for (const char* size : {"", "100", "100x", "x100", "100x100x", "-100x100", "10x10", "1e3x500"})
    EXPECT_THROW((void)parseImageSize(size), UsageError) << size;
  EXPECT_EQ(parseImageSize("1280x720").width, 1280);
  EXPECT_THROW((void)loadScene(run_.dir() / "absent"), UsageError);
  const SceneInputs scene = loadScene(run_.dir());
  EXPECT_THROW((void)frameScene(scene, parseView("uav:c"), kSize), UsageError);
  EXPECT_THROW((void)frameScene({}, parseView("top"), kSize), RunError);
  EXPECT_THROW(renderSnapshot(scene, parseView("top"), kSize, run_.dir() / "no/such/p.png"),
               RunError);
  const std::string world = support::fileText(run_.dir() / "world.json");
  for (const char* bad : {"[]", R"({"center":7})", R"({"origin":{"h":"high"}})"}) {
    writeFileAtomically(run_.dir() / "world.json", bad);
    EXPECT_THROW((void)loadScene(run_.dir()), RunError) << bad;
  }
  writeFileAtomically(run_.dir() / "world.json", world);
  SceneLimits limits;
  limits.with_voxels = true;
  fs::resize_file(run_.dir() / "octomap.ot", fs::file_size(run_.dir() / "octomap.ot") / 2);
  EXPECT_THROW((void)loadScene(run_.dir(), limits), RunError);
  std::ofstream(run_.dir() / "octomap.ot") << "not an octomap";
  EXPECT_THROW((void)loadScene(run_.dir(), limits), RunError);
  fs::remove(run_.dir() / "cloud/cloud.ply");
  EXPECT_THROW((void)loadScene(run_.dir()), RunError);
}

int statusOf(const std::string& arguments) {
  const int status = std::system(
      (std::string(CF_BIN_DIR "/cf-snapshot ") + arguments + " >/dev/null 2>&1").c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST_F(Snapshot, CommandLineFollowsTheContract) {
  const std::string dir = run_.dir().string(), png = dir + "/cli.png";
  EXPECT_EQ(statusOf(dir + " --view uav:b --size 320x240 -o " + png), 0);
  const cv::Mat picture = cv::imread(png);
  EXPECT_EQ(picture.cols, 320);
  EXPECT_EQ(picture.rows, 240);
  EXPECT_EQ(statusOf("--help"), 0);
  EXPECT_EQ(statusOf("--version"), 0);
  EXPECT_EQ(statusOf(""), 2);
  EXPECT_EQ(statusOf(dir), 2);
  EXPECT_EQ(statusOf(dir + " --view side -o " + png), 2);
  EXPECT_EQ(statusOf(dir + " --size big -o " + png), 2);
  EXPECT_EQ(statusOf(dir + "/absent -o " + png), 2);
  EXPECT_EQ(statusOf(dir + " -o " + dir + "/no/such/folder.png"), 1);
}

}  // namespace
}  // namespace cf
