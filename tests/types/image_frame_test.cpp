// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/types/image_frame.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

namespace cf {
namespace {

const Eigen::Vector3d kEast(1, 0, 0), kNorth(0, 1, 0), kUp(0, 0, 1);
const Eigen::Vector3d kRight(1, 0, 0), kTop(0, -1, 0), kForward(0, 0, 1);

/// Where the photo's right, its top and the optical axis point to.
void expectAxes(const GimbalAttitude& attitude, const Eigen::Vector3d& right,
                const Eigen::Vector3d& top, const Eigen::Vector3d& forward) {
  const Eigen::Matrix3d R_world_cam = rotationWorldCam(attitude);
  EXPECT_TRUE((R_world_cam * kRight).isApprox(right, 1e-12)) << (R_world_cam * kRight).transpose();
  EXPECT_TRUE((R_world_cam * kTop).isApprox(top, 1e-12)) << (R_world_cam * kTop).transpose();
  EXPECT_TRUE((R_world_cam * kForward).isApprox(forward, 1e-12))
      << (R_world_cam * kForward).transpose();
}

TEST(RotationWorldCam, lookingDownTheTopFollowsTheYaw) {
  expectAxes({0, -90, 0}, kEast, kNorth, -kUp);
  expectAxes({90, -90, 0}, -kNorth, kEast, -kUp);
  expectAxes({180, -90, 0}, -kEast, -kNorth, -kUp);
  expectAxes({-90, -90, 0}, kNorth, -kEast, -kUp);
}

TEST(RotationWorldCam, levelItLooksWhereTheYawPoints) {
  expectAxes({0, 0, 0}, kEast, kUp, kNorth);
  expectAxes({90, 0, 0}, -kNorth, kUp, kEast);
}

TEST(RotationWorldCam, pitchedForwardItSeesTheGroundAhead) {
  // 16 degrees forward of nadir, flying north.
  const double tilt = 16 * M_PI / 180;
  expectAxes({0, -74, 0}, kEast, std::cos(tilt) * kNorth + std::sin(tilt) * kUp,
             std::sin(tilt) * kNorth - std::cos(tilt) * kUp);
}

TEST(RotationWorldCam, rollTurnsAboutTheOpticalAxis) {
  // Level, looking north, right wing down: the photo's right points below the horizon.
  const double roll = 10 * M_PI / 180;
  expectAxes({0, 0, 10}, std::cos(roll) * kEast - std::sin(roll) * kUp,
             std::sin(roll) * kEast + std::cos(roll) * kUp, kNorth);
}

TEST(RotationWorldCam, isARotationForAnyAttitude) {
  for (double yaw = -180; yaw <= 360; yaw += 37)
    for (double pitch = -120; pitch <= 30; pitch += 13)
      for (double roll = -180; roll <= 180; roll += 29) {
        const Eigen::Matrix3d R = rotationWorldCam({yaw, pitch, roll});
        ASSERT_TRUE((R * R.transpose()).isIdentity(1e-12));
        ASSERT_NEAR(R.determinant(), 1, 1e-12);
      }
}

}  // namespace
}  // namespace cf
