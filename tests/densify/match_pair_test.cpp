// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <tuple>
#include <vector>

#include "cf/densify/densify.h"
#include "cf/geometry/depth_triangulation.h"
#include "support/stereo_scene.h"

namespace cf {
namespace {

using support::cameraAt;
using support::distortedCamera;
using support::HouseScene;
using support::photograph;

DenseView viewOf(const PosedCamera& camera, std::uint32_t index) {
  DenseView view;
  view.id = {0, index};
  view.T_world_cam = camera.T_world_cam;
  view.camera = camera.camera;
  // As sparse features would say: the roof holds few of them.
  view.near_depth_m = 0.95 * camera.T_world_cam.translation().z();
  view.median_depth_m = camera.T_world_cam.translation().z();
  view.far_depth_m = 1.03 * camera.T_world_cam.translation().z();
  return view;
}

struct Accuracy {
  double matched = 0;    // share of the pixels that both photos see
  double median_px = 0;  // height error over the height of one disparity step of 1 px
  double p90_px = 0;
  double flying = 0;         // share more than 1 m off any surface
  double roof_median_m = 0;  // of the points on the roof
};

Accuracy accuracyOf(const HouseScene& scene, const DepthFrame& frame, const PosedCamera& a,
                    const PosedCamera& b) {
  const auto points = triangulateDepth(frame, a, b);
  const double height = a.T_world_cam.translation().z();
  const double step_m = height * height / frame.reference_view.f /
                        (a.T_world_cam.translation() - b.T_world_cam.translation()).norm();
  std::vector<double> errors, roof;
  int flying = 0;
  for (const MapPoint& p : points.points) {
    const Eigen::Vector3d world = points.world(p);
    const double x = world.x(), y = world.y(), z = world.z();
    const double wall = scene.distanceToWall(x, y);
    const bool between = std::abs(wall) < 1 && z > -1 && z < scene.roof_m + 1;
    if (std::abs(z - scene.height(x, y)) > 1 && !between) ++flying;
    if (std::abs(wall) < 1) continue;
    errors.push_back(std::abs(z - scene.height(x, y)) / step_m);
    if (wall < -1) roof.push_back(z);
  }
  std::sort(errors.begin(), errors.end());
  std::sort(roof.begin(), roof.end());
  Accuracy accuracy;
  int common = 0;
  for (int v = 0; v < frame.disparity.rows; v += 4) {
    for (int u = 0; u < frame.disparity.cols; u += 4) {
      const Eigen::Vector3d rect((u - frame.reference_view.cx) / frame.reference_view.f,
                                 (v - frame.reference_view.cy) / frame.reference_view.f, 1);
      const Eigen::Vector3d ray = frame.reference_view.R_rect_cam.transpose() * rect;
      const Eigen::Vector3d p =
          scene.hit(a.T_world_cam.translation(), a.T_world_cam.linear() * ray);
      const Eigen::Vector3d p_b = b.T_world_cam.inverse() * p;
      common +=
          a.camera.contains(a.camera.project(ray)) && b.camera.contains(b.camera.project(p_b));
    }
  }
  const double n = static_cast<double>(points.points.size());
  accuracy.matched = n / (16.0 * common);
  accuracy.median_px = errors[errors.size() / 2];
  accuracy.p90_px = errors[errors.size() * 9 / 10];
  accuracy.flying = flying / n;
  accuracy.roof_median_m = roof.empty() ? 0 : roof[roof.size() / 2];
  return accuracy;
}

struct Pair {
  double dx, dy, yaw;
};
class MatchPair : public testing::TestWithParam<std::tuple<Pair, const char*>> {};

TEST_P(MatchPair, measuresGroundAndRoofForAnyBaseline) {
  const auto [d, matcher] = GetParam();
  DensifyOptions options;
  options.matcher = matcher;
  const HouseScene scene;
  const PosedCamera a = cameraAt(distortedCamera(), -d.dx / 2, -d.dy / 2, 50, 0.2, 0.03, -0.02);
  const PosedCamera b =
      cameraAt(distortedCamera(), d.dx / 2, d.dy / 2, 50.5, 0.2 + d.yaw, -0.02, 0.03);
  const auto frame =
      matchPair(viewOf(a, 0), photograph(scene, a), viewOf(b, 1), photograph(scene, b), options);
  ASSERT_TRUE(frame.ok()) << frame.failure().detail;
  EXPECT_EQ(frame->reference.index, 0U);
  EXPECT_EQ(frame->partner.index, 1U);
  const Accuracy accuracy = accuracyOf(scene, *frame, a, b);
  RecordProperty("matched", std::to_string(accuracy.matched));
  std::printf("matched %.3f, median %.3f px, p90 %.3f px, flying %.4f, roof %.2f m\n",
              accuracy.matched, accuracy.median_px, accuracy.p90_px, accuracy.flying,
              accuracy.roof_median_m);
  EXPECT_GT(accuracy.matched, 0.93);
  EXPECT_LT(accuracy.median_px, 0.1);
  EXPECT_LT(accuracy.p90_px, 0.3);
  EXPECT_LT(accuracy.flying, 0.002);
  EXPECT_NEAR(accuracy.roof_median_m, scene.roof_m, 0.1);
}

INSTANTIATE_TEST_SUITE_P(Directions, MatchPair,
                         testing::Combine(testing::Values(Pair{14, 0, 0}, Pair{-14, 0, 0.05},
                                                          Pair{0, 12, 0}, Pair{0, -12, 0},
                                                          Pair{9, 9, 0}, Pair{-9, 9, 3.1}),
                                          testing::Values("sgm", "elas")));

TEST(MatchPair, withstandsAnotherExposureAndAReducedPhoto) {
  const HouseScene scene;
  const PosedCamera a = cameraAt(distortedCamera(), -6, 0, 50);
  const PosedCamera b = cameraAt(distortedCamera(), 6, 0, 50);
  DensifyOptions options;
  const auto bright = matchPair(viewOf(a, 0), photograph(scene, a), viewOf(b, 1),
                                photograph(scene, b, 0.6, 60), options);
  ASSERT_TRUE(bright.ok());
  EXPECT_GT(accuracyOf(scene, *bright, a, b).matched, 0.85);
  EXPECT_LT(accuracyOf(scene, *bright, a, b).median_px, 0.2);

  // Decoded at half its size: the frame's cameras stay those of the whole photo.
  PosedCamera small_a = a, small_b = b;
  small_a.camera = small_b.camera = a.camera.scaled(320, 240);
  const auto half = matchPair(viewOf(a, 0), photograph(scene, small_a), viewOf(b, 1),
                              photograph(scene, small_b), options);
  ASSERT_TRUE(half.ok());
  EXPECT_LE(half->reference_view.f, small_a.camera.fx);
  EXPECT_EQ(half->reference_camera.width, 640);
  EXPECT_LT(accuracyOf(scene, *half, a, b).median_px, 0.2);
}

TEST(MatchPair, matchesTheWantedSize) {
  const HouseScene scene;
  const PosedCamera a = cameraAt(distortedCamera(), -5, 0, 50);
  const PosedCamera b = cameraAt(distortedCamera(), 5, 0, 50);
  DensifyOptions options;
  options.megapixels = 0.06;
  const auto frame =
      matchPair(viewOf(a, 0), photograph(scene, a), viewOf(b, 1), photograph(scene, b), options);
  ASSERT_TRUE(frame.ok());
  EXPECT_NEAR(static_cast<double>(frame->disparity.total()), 0.06e6, 0.012e6);
  EXPECT_EQ(frame->disparity.size(), frame->confidence.size());
  EXPECT_EQ(frame->disparity.size(), frame->colour.size());
}

class EachMatcher : public testing::TestWithParam<const char*> {};

TEST_P(EachMatcher, givesTheSameBytesForTheSameInput) {
  DensifyOptions options;
  options.matcher = GetParam();
  const HouseScene scene;
  const PosedCamera a = cameraAt(distortedCamera(), -5, 0, 50);
  const PosedCamera b = cameraAt(distortedCamera(), 5, 2, 50);
  const cv::Mat image_a = photograph(scene, a), image_b = photograph(scene, b);
  const auto once = matchPair(viewOf(a, 0), image_a, viewOf(b, 1), image_b, options);
  const auto again = matchPair(viewOf(a, 0), image_a, viewOf(b, 1), image_b, options);
  ASSERT_TRUE(once.ok() && again.ok());
  EXPECT_EQ(cv::norm(once->disparity, again->disparity, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(once->confidence, again->confidence, cv::NORM_INF), 0);
}

TEST_P(EachMatcher, saysWhyThereIsNoDepth) {
  DensifyOptions options;
  options.matcher = GetParam();
  const HouseScene scene;
  const PosedCamera a = cameraAt(distortedCamera(), -5, 0, 50);
  const PosedCamera b = cameraAt(distortedCamera(), 5, 0, 50);
  const cv::Mat image = photograph(scene, a);
  const cv::Mat blank(image.size(), CV_8UC3, cv::Scalar::all(120));
  const auto codeOf = [](const Result<DepthFrame>& result) {
    return result.ok() ? std::string("ok") : result.failure().code;
  };
  EXPECT_EQ(codeOf(matchPair(viewOf(a, 0), image, viewOf(b, 1), blank, options)), "no_match");
  EXPECT_EQ(codeOf(matchPair(viewOf(a, 0), blank, viewOf(b, 1), blank, options)), "no_match");
  DenseView no_depth = viewOf(a, 0);
  no_depth.near_depth_m = no_depth.median_depth_m = no_depth.far_depth_m = 0;
  EXPECT_EQ(codeOf(matchPair(no_depth, image, viewOf(b, 1), image, options)), "no_depth");
  DenseView at_its_feet = viewOf(a, 0);  // thousands of pixels of disparity
  at_its_feet.near_depth_m = 1;
  EXPECT_EQ(codeOf(matchPair(at_its_feet, image, viewOf(b, 1), image, options)), "wide_range");
  const PosedCamera far_away = cameraAt(distortedCamera(), 90, 0, 50);
  EXPECT_EQ(codeOf(matchPair(viewOf(a, 0), image, viewOf(far_away, 1), image, options)),
            "little_overlap");
}

INSTANTIATE_TEST_SUITE_P(Matchers, EachMatcher, testing::Values("sgm", "elas"));

}  // namespace
}  // namespace cf
