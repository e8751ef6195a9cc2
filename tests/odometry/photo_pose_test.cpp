// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "photo_pose.h"

#include <gtest/gtest.h>

#include <random>

#include "support/views.h"

namespace cf {
namespace {

const Eigen::Vector2d kCorner(0.75, 0.56);

Eigen::Isometry3d poseAt(double x) { return support::nadirPose({x, 1, 60}, 3, 1, -2); }

/// Landmarks on gentle relief, `from` to `to` metres east of the origin, as a camera sees them.
std::vector<LandmarkSight> sights(const Eigen::Isometry3d& T, double from, double to, int count) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> x(from, to), y(-30, 30), z(0, 4);
  std::vector<LandmarkSight> out;
  while (static_cast<int>(out.size()) < count) {
    const Eigen::Vector3d p(x(random), y(random), z(random));
    out.push_back({p, (T.inverse() * p).hnormalized()});
  }
  return out;
}

TEST(StrayAtCorners, TellsAStripAtTheEdgeFromAWholePhoto) {
  const Eigen::Isometry3d T = poseAt(0);
  const double sigma = 1e-3;
  const double whole = strayAtCorners(T, sights(T, -40, 40, 40), kCorner, sigma);
  const double strip = strayAtCorners(T, sights(T, -40, -36, 40), kCorner, sigma);
  EXPECT_GT(whole, 0.3 * sigma);
  EXPECT_LT(whole, 1.5 * sigma);
  EXPECT_GT(strip, 5 * sigma);
  // In proportion to the noise, and to one over the root of the number.
  EXPECT_NEAR(strayAtCorners(T, sights(T, -40, 40, 40), kCorner, 3 * sigma), 3 * whole, 1e-9);
  auto twice = sights(T, -40, 40, 40);
  twice.insert(twice.end(), twice.begin(), twice.begin() + 40);
  EXPECT_NEAR(strayAtCorners(T, twice, kCorner, sigma), whole / std::sqrt(2.0), 1e-9);
}

TEST(StrayAtCorners, IsInfiniteWithoutAPose) {
  const Eigen::Isometry3d T = poseAt(0);
  EXPECT_TRUE(std::isinf(strayAtCorners(T, {}, kCorner, 1e-3)));
  EXPECT_TRUE(std::isinf(strayAtCorners(T, sights(T, -40, 40, 2), kCorner, 1e-3)));
}

/// Five landmarks along one edge give a baseline its length, wrong ones among them or not.
TEST(PoseByScaledTwoView, TakesItsLengthFromAHandful) {
  const Eigen::Isometry3d T_local_a = poseAt(0), T_local_cam = poseAt(36);
  Eigen::Isometry3d T_a_cam = T_local_a.inverse() * T_local_cam;
  T_a_cam.translation().normalize();
  auto seen = sights(T_local_cam, 0, 4, 5);
  for (const int wrong : {0, 4}) {
    for (int i = 0; i < wrong; ++i)
      seen.push_back({seen[0].p_local, seen[0].normalized + Eigen::Vector2d(0.1 + 0.05 * i, 0.02)});
    const auto pose = poseByScaledTwoView(T_local_a, T_a_cam, seen, 3e-3, 5);
    ASSERT_TRUE(pose) << pose.failure().detail;
    EXPECT_LT((pose->translation() - T_local_cam.translation()).norm(), 1e-9);
    EXPECT_LT(support::rotationErrorDeg(*pose, T_local_cam), 1e-9);
  }
}

/// Flown straight ahead, a landmark in the middle lies on the baseline: it tells nothing of its
/// length, and takes nothing from the others.
TEST(PoseByScaledTwoView, BearsALandmarkOnTheBaseline) {
  Eigen::Isometry3d T_local_cam = Eigen::Isometry3d::Identity();
  T_local_cam.translation().z() = 2;
  Eigen::Isometry3d T_a_cam = Eigen::Isometry3d::Identity();
  T_a_cam.translation().z() = 1;
  std::vector<LandmarkSight> seen = {{{0, 0, 10}, {0, 0}}};
  for (const auto& p : {Eigen::Vector3d(3, 1, 10), Eigen::Vector3d(-2, 2, 12),
                        Eigen::Vector3d(1, -3, 9), Eigen::Vector3d(-3, -1, 11)})
    seen.push_back({p, (T_local_cam.inverse() * p).hnormalized()});
  const auto pose = poseByScaledTwoView(Eigen::Isometry3d::Identity(), T_a_cam, seen, 3e-3, 5);
  ASSERT_TRUE(pose) << pose.failure().detail;
  EXPECT_LT((pose->translation() - T_local_cam.translation()).norm(), 1e-9);
}

TEST(PoseByScaledTwoView, FailsWhereLandmarksAreFewOrDisagree) {
  const Eigen::Isometry3d T_local_a = poseAt(0), T_local_cam = poseAt(36);
  Eigen::Isometry3d T_a_cam = T_local_a.inverse() * T_local_cam;
  T_a_cam.translation().normalize();
  const auto four = sights(T_local_cam, 0, 4, 4);
  EXPECT_EQ(poseByScaledTwoView(T_local_a, T_a_cam, four, 3e-3, 5).failure().code, "no_scale");
  auto seen = sights(T_local_cam, 0, 4, 12);
  std::mt19937 random(2);
  std::uniform_real_distribution<double> anywhere(-0.7, 0.7);
  for (auto& s : seen) s.normalized = {anywhere(random), anywhere(random)};
  EXPECT_EQ(poseByScaledTwoView(T_local_a, T_a_cam, seen, 3e-3, 5).failure().code, "no_scale");
  // The camera would have to stand on the other side of a.
  T_a_cam.translation() *= -1;
  EXPECT_FALSE(poseByScaledTwoView(T_local_a, T_a_cam, sights(T_local_cam, 0, 4, 12), 3e-3, 5));
}

}  // namespace
}  // namespace cf
