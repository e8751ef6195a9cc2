// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/geometry/rectification.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "support/stereo_scene.h"

namespace cf {
namespace {

using support::cameraAt;
using support::distortedCamera;

Eigen::Vector2d projectInto(const RectifiedView& view, const PosedCamera& camera,
                            const Eigen::Vector3d& p_world) {
  const Eigen::Vector3d p = view.R_rect_cam * (camera.T_world_cam.inverse() * p_world);
  return {view.f * p.x() / p.z() + view.cx, view.f * p.y() / p.z() + view.cy};
}

RectificationRequest request() {
  RectificationRequest r;
  r.megapixels = 0.2;
  r.near_depth_m = 40;
  r.far_depth_m = 52;
  r.search_near_depth_m = 35;
  r.search_far_depth_m = 60;
  return r;
}

struct Direction {
  double dx, dy, dz, yaw;
};
class AnyBaseline : public testing::TestWithParam<Direction> {};

TEST_P(AnyBaseline, rowsAreEpipolarLinesAndDisparityIsDepth) {
  const Direction d = GetParam();
  const PosedCamera a = cameraAt(distortedCamera(), 0, 0, 50, 0.4, 0.05, -0.03);
  const PosedCamera b =
      cameraAt(distortedCamera(), d.dx, d.dy, 50 + d.dz, 0.4 + d.yaw, -0.04, 0.06);
  const auto pair = rectifyPair(a, b, request());
  ASSERT_TRUE(pair.ok()) << pair.failure().detail;
  EXPECT_NEAR(pair->baseline_m, std::sqrt(d.dx * d.dx + d.dy * d.dy + d.dz * d.dz), 1e-9);
  EXPECT_NEAR((pair->reference.R_rect_cam * pair->reference.R_rect_cam.transpose() -
               Eigen::Matrix3d::Identity())
                  .norm(),
              0, 1e-12);
  EXPECT_NEAR(pair->reference.R_rect_cam.determinant(), 1, 1e-12);

  // Every point that both photos see lies in both views, on the same row, within the range.
  std::mt19937 random(7);
  std::uniform_real_distribution<double> share(0, 1);
  int common = 0;
  for (int k = 0; k < 20000; ++k) {
    const Eigen::Vector2d pixel(639 * share(random), 479 * share(random));
    const double depth = 40 + 12 * share(random);
    const Eigen::Vector3d ray = a.camera.undistort(pixel).homogeneous();
    const Eigen::Vector3d p = a.T_world_cam * Eigen::Vector3d(depth * ray);
    const Eigen::Vector3d p_b = b.T_world_cam.inverse() * p;
    if (!b.camera.contains(b.camera.project(p_b))) continue;
    ++common;
    const Eigen::Vector2d left = projectInto(pair->reference, a, p);
    const Eigen::Vector2d right = projectInto(pair->partner, b, p);
    ASSERT_NEAR(left.y(), right.y(), 1e-8);
    const double disparity = left.x() - right.x();
    ASSERT_GE(disparity, pair->min_disparity_px);
    ASSERT_LE(disparity, pair->max_disparity_px);
    const double z = (pair->reference.R_rect_cam * Eigen::Vector3d(depth * ray)).z();
    ASSERT_NEAR(pair->depth(disparity), z, 1e-6);
    ASSERT_NEAR(pair->disparity(z), disparity, 1e-6);
    // The crop is found on a grid of samples: half a step of it may be missing.
    const double slack = 640.0 / 48;
    ASSERT_GT(left.x(), -slack);
    ASSERT_LT(left.x(), pair->reference.width + slack);
    ASSERT_GT(left.y(), -slack);
    ASSERT_LT(left.y(), pair->reference.height + slack);
  }
  EXPECT_NEAR(pair->overlap, common / 20000.0, 0.06);
  EXPECT_LE(pair->reference.f, a.camera.fx);
  EXPECT_LE(pair->reference.width * pair->reference.height, 0.41e6);
}

INSTANTIATE_TEST_SUITE_P(Directions, AnyBaseline,
                         testing::Values(Direction{15, 0, 0, 0}, Direction{-15, 0, 0.5, 0},
                                         Direction{0, 12, 0, 0.05}, Direction{0, -12, 1, 0},
                                         Direction{10, 10, 0, 0}, Direction{-9, 11, -2, 3.1},
                                         Direction{8, -8, 3, 1.6}));

TEST(Rectification, neverExceedsThePhotosResolution) {
  const PosedCamera a = cameraAt(distortedCamera(), 0, 0, 50);
  const PosedCamera b = cameraAt(distortedCamera(), 12, 0, 50);
  RectificationRequest r = request();
  r.megapixels = 100;
  EXPECT_DOUBLE_EQ(rectifyPair(a, b, r)->reference.f, a.camera.fx);
  r.megapixels = 0.05;
  const auto small = rectifyPair(a, b, r);
  EXPECT_NEAR(small->reference.width * small->reference.height, 0.05e6, 0.01e6);
}

TEST(Rectification, saysWhyAPairIsNone) {
  const PosedCamera a = cameraAt(distortedCamera(), 0, 0, 50);
  const auto code = [&](const PosedCamera& b) {
    const auto pair = rectifyPair(a, b, request());
    return pair.ok() ? std::string("ok") : pair.failure().code;
  };
  EXPECT_EQ(code(a), "no_baseline");
  EXPECT_EQ(code(cameraAt(distortedCamera(), 2, 1, 40)), "forward_motion");
  EXPECT_EQ(code(cameraAt(distortedCamera(), 75, 0, 50)), "little_overlap");
  EXPECT_EQ(code(cameraAt(distortedCamera(), 10, 0, 50, 0, 1.5)), "diverging_views");
}

TEST(Rectification, remapTableIsTheExactMapping) {
  const CameraModel full = distortedCamera();
  const PosedCamera a = cameraAt(full, 0, 0, 50, 0.4, 0.1, -0.1);
  const PosedCamera b = cameraAt(full, 10, 9, 50, 0.4, -0.1, 0.1);
  const auto pair = rectifyPair(a, b, request());
  ASSERT_TRUE(pair.ok());
  const CameraModel image = full.scaled(320, 240);  // a reduced decoding
  const RemapTable table = remapTable(pair->reference, image);
  ASSERT_EQ(table.fixed_xy.cols, pair->reference.width);
  double worst = 0;
  int inside = 0;
  for (int v = 0; v < table.fixed_xy.rows; ++v) {
    for (int u = 0; u < table.fixed_xy.cols; ++u) {
      const Eigen::Vector3d ray = pair->reference.R_rect_cam.transpose() *
                                  Eigen::Vector3d((u - pair->reference.cx) / pair->reference.f,
                                                  (v - pair->reference.cy) / pair->reference.f, 1);
      const Eigen::Vector2d exact = image.project(ray);
      const auto xy = table.fixed_xy.at<cv::Vec2s>(v, u);
      const int fraction = table.fraction.at<ushort>(v, u);
      const Eigen::Vector2d got(xy[0] + (fraction & 31) / 32.0, xy[1] + (fraction >> 5) / 32.0);
      const bool in = exact.x() > 0 && exact.y() > 0 && exact.x() < 319 && exact.y() < 239;
      const bool near_edge =
          std::min({std::abs(exact.x()), std::abs(exact.y()), std::abs(exact.x() - 319),
                    std::abs(exact.y() - 239)}) < 0.05;
      ASSERT_TRUE(near_edge || (table.inside.at<uchar>(v, u) != 0) == in) << u << " " << v;
      if (!in) continue;
      ++inside;
      worst = std::max(worst, (got - exact).cwiseAbs().maxCoeff());
    }
  }
  EXPECT_GT(inside, 20000);
  EXPECT_LT(worst, 1.0 / 64 + 0.01);  // rounding to 1/32 px, and the grid's own error
}

}  // namespace
}  // namespace cf
