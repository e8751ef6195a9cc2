// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/geometry/depth_triangulation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/stereo_scene.h"

namespace cf {
namespace {

using support::cameraAt;
using support::distortedCamera;

/// The frame that a perfect matcher makes over a tilted plane, z = 0.1 x, quantised to 1/16 px.
struct PerfectFrame {
  PosedCamera a = cameraAt(distortedCamera(), 0, 0, 50, 0.4, 0.05, -0.03);
  PosedCamera b = cameraAt(distortedCamera(), 9, 10, 51, 0.45, -0.04, 0.06);
  DepthFrame frame;

  PerfectFrame() {
    RectificationRequest request;
    request.megapixels = 0.1;
    request.near_depth_m = 45;
    request.far_depth_m = 56;
    const auto pair = rectifyPair(a, b, request);
    frame.reference_view = pair->reference;
    frame.partner_view = pair->partner;
    frame.reference_camera = a.camera;
    frame.partner_camera = b.camera;
    frame.T_reference_partner = pair->T_reference_partner;
    frame.disparity_offset_px = pair->min_disparity_px - 1;
    const cv::Size size(pair->reference.width, pair->reference.height);
    frame.disparity.create(size, CV_16U);
    frame.confidence = cv::Mat(size, CV_8U, cv::Scalar(255));
    frame.colour = cv::Mat(size, CV_8UC3, cv::Scalar(10, 20, 30));
    for (int v = 0; v < size.height; ++v) {
      for (int u = 0; u < size.width; ++u) {
        const Eigen::Vector3d rect((u - pair->reference.cx) / pair->reference.f,
                                   (v - pair->reference.cy) / pair->reference.f, 1);
        const Eigen::Vector3d ray =
            a.T_world_cam.linear() * (pair->reference.R_rect_cam.transpose() * rect);
        const Eigen::Vector3d normal(-0.1, 0, 1);
        const double depth = -normal.dot(a.T_world_cam.translation()) / normal.dot(ray);
        const double stored = 16 * (pair->disparity(depth) - frame.disparity_offset_px) + 1;
        frame.disparity.at<ushort>(v, u) =
            stored < 1 ? ushort{0} : static_cast<ushort>(std::lround(stored));
      }
    }
  }
};

double worstHeightError(const MapPoints& points) {
  double worst = 0;
  for (const MapPoint& p : points.points) {
    const Eigen::Vector3d world = points.world(p);
    worst = std::max(worst, std::abs(world.z() - 0.1 * world.x()));
  }
  return worst;
}

TEST(DepthTriangulation, exactDisparitiesGiveTheSurface) {
  const PerfectFrame perfect;
  const auto points = triangulateDepth(perfect.frame, perfect.a, perfect.b);
  ASSERT_GT(points.points.size(), 0.9 * static_cast<double>(perfect.frame.disparity.total()));
  // Half a step of 1/16 px at 50 m, b = 13.5 m, f of about 360 px: 17 mm.
  EXPECT_LT(worstHeightError(points), 0.025);
  EXPECT_EQ(points.points[0].bgr[0], 10);
  EXPECT_EQ(points.points[0].bgr[2], 30);
}

TEST(DepthTriangulation, takesThePosesAsTheyAreNow) {
  const PerfectFrame perfect;
  Eigen::Isometry3d moved = Eigen::Isometry3d::Identity();
  moved.linear() = Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  moved.translation() << 100, -200, 30;
  const auto before = triangulateDepth(perfect.frame, perfect.a, perfect.b);
  const auto after =
      triangulateDepth(perfect.frame, {moved * perfect.a.T_world_cam, perfect.a.camera},
                       {moved * perfect.b.T_world_cam, perfect.b.camera});
  ASSERT_EQ(before.points.size(), after.points.size());
  for (std::size_t k = 0; k < before.points.size(); k += 101) {
    EXPECT_LT((after.world(after.points[k]) - moved * before.world(before.points[k])).norm(), 1e-4);
  }
}

TEST(DepthTriangulation, aRefinedCameraIsFollowedThroughItsPixels) {
  // Matched with a wrong camera, triangulated with the right one: pixels that truly match meet on
  // the surface again.
  const PosedCamera a = cameraAt(distortedCamera(), 0, 0, 50);
  const PosedCamera b = cameraAt(distortedCamera(), 12, 0, 50);
  CameraModel wrong = distortedCamera();
  wrong.k1 += 0.01;
  wrong.fx = wrong.fy = 530;
  PosedCamera a_then = a, b_then = b;
  a_then.camera = b_then.camera = wrong;
  RectificationRequest request;
  request.megapixels = 0.1;
  request.near_depth_m = 45;
  request.far_depth_m = 55;
  const auto pair = rectifyPair(a_then, b_then, request);
  ASSERT_TRUE(pair.ok());
  DepthFrame frame;
  frame.reference_view = pair->reference;
  frame.partner_view = pair->partner;
  frame.reference_camera = frame.partner_camera = wrong;
  frame.disparity_offset_px = -600;
  const cv::Size size(pair->reference.width, pair->reference.height);
  frame.disparity = cv::Mat(size, CV_16U, cv::Scalar(0));
  frame.confidence = cv::Mat(size, CV_8U, cv::Scalar(128));
  frame.colour = cv::Mat(size, CV_8UC3, cv::Scalar(0));
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      const Eigen::Vector3d rect((u - pair->reference.cx) / pair->reference.f,
                                 (v - pair->reference.cy) / pair->reference.f, 1);
      const Eigen::Vector2d pixel = wrong.project(pair->reference.R_rect_cam.transpose() * rect);
      const Eigen::Vector3d ray = a.camera.undistort(pixel).homogeneous();
      const Eigen::Vector3d ground = a.T_world_cam * Eigen::Vector3d(50 * ray);
      const Eigen::Vector2d pixel_b = b.camera.project(b.T_world_cam.inverse() * ground);
      const Eigen::Vector3d ray_b =
          pair->partner.R_rect_cam * wrong.undistort(pixel_b).homogeneous();
      const double u_b = pair->partner.f * ray_b.x() / ray_b.z() + pair->partner.cx;
      if (u_b < 0 || u_b > pair->partner.width) continue;
      frame.disparity.at<ushort>(v, u) =
          static_cast<ushort>(std::lround(16 * (u - u_b - frame.disparity_offset_px) + 1));
    }
  }
  // Rows were no epipolar lines for the wrong camera, so that the stored row is off a little too:
  // the surface is met as far as that allows, and much better than without following.
  const auto follow = triangulateDepth(frame, a, b);
  const auto naive = triangulateDepth(frame, a_then, b_then);
  const auto rms = [](const MapPoints& points) {
    double sum = 0;
    for (const MapPoint& p : points.points) {
      const double z = points.world(p).z();
      sum += z * z;
    }
    return std::sqrt(sum / static_cast<double>(points.points.size()));
  };
  ASSERT_GT(follow.points.size(), 20000U);
  EXPECT_LT(rms(follow), 0.05);
  EXPECT_GT(rms(naive), 0.5);
}

TEST(DepthTriangulation, weightIsInverseVarianceTimesConfidence) {
  PerfectFrame perfect;
  perfect.frame.confidence.setTo(51);
  DepthTriangulationOptions options;
  options.stride = 5;
  const auto low = triangulateDepth(perfect.frame, perfect.a, perfect.b, options);
  perfect.frame.confidence.setTo(255);
  const auto full = triangulateDepth(perfect.frame, perfect.a, perfect.b, options);
  ASSERT_EQ(low.points.size(), full.points.size());
  EXPECT_NEAR(low.points[10].weight / full.points[10].weight, 0.2, 1e-6);
  const double fb =
      perfect.frame.reference_view.f *
      (perfect.a.T_world_cam.translation() - perfect.b.T_world_cam.translation()).norm();
  const double sigma = 50 * 50 / fb * options.disparity_sigma_px;
  EXPECT_NEAR(full.points[full.points.size() / 2].weight * sigma * sigma, 1, 0.35);
  options.min_confidence = 52;
  perfect.frame.confidence.setTo(51);
  EXPECT_TRUE(triangulateDepth(perfect.frame, perfect.a, perfect.b, options).points.empty());
}

}  // namespace
}  // namespace cf
