// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/types/sim3.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <random>

namespace cf {
namespace {

class Sim3Test : public ::testing::Test {
 protected:
  double draw(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  Eigen::Vector3d point() { return {draw(-100, 100), draw(-100, 100), draw(-100, 100)}; }
  Eigen::Matrix3d rotation() {
    return Eigen::Quaterniond(draw(-1, 1), draw(-1, 1), draw(-1, 1), draw(-1, 1))
        .normalized()
        .toRotationMatrix();
  }
  Sim3 similarity() { return {draw(0.1, 50), rotation(), point()}; }

  std::mt19937 random_{7};
};

TEST_F(Sim3Test, actsAsScaleRotationTranslation) {
  const Sim3 S{
      2, Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix(), {10, 20, 30}};
  EXPECT_TRUE((S * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(10, 22, 30), 1e-15));
  EXPECT_EQ(Sim3{} * Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(1, 2, 3));
}

TEST_F(Sim3Test, aProductActsAsOneAfterTheOther) {
  for (int i = 0; i < 100; ++i) {
    const Sim3 S_a_b = similarity(), S_b_c = similarity();
    const Eigen::Vector3d p_c = point();
    EXPECT_TRUE(((S_a_b * S_b_c) * p_c).isApprox(S_a_b * (S_b_c * p_c), 1e-12));
  }
}

TEST_F(Sim3Test, theInverseUndoesOnBothSides) {
  for (int i = 0; i < 100; ++i) {
    const Sim3 S = similarity();
    const Eigen::Vector3d p = point();
    EXPECT_LT((S.inverse() * (S * p) - p).norm(), 1e-10);
    EXPECT_LT((S * (S.inverse() * p) - p).norm(), 1e-10);
    EXPECT_NEAR((S * S.inverse()).scale, 1, 1e-14);
  }
}

TEST_F(Sim3Test, carryKeepsWhatACameraSees) {
  for (int i = 0; i < 100; ++i) {
    const Sim3 S_a_b = similarity();
    Eigen::Isometry3d T_b_cam = Eigen::Isometry3d::Identity();
    T_b_cam.linear() = rotation();
    T_b_cam.translation() = point();
    const Eigen::Isometry3d T_a_cam = S_a_b.carry(T_b_cam);
    EXPECT_TRUE((T_a_cam.linear() * T_a_cam.linear().transpose()).isIdentity(1e-12));
    EXPECT_NEAR(T_a_cam.linear().determinant(), 1, 1e-12);
    // A point and the camera carried along: the same direction, the distance times the scale.
    const Eigen::Vector3d p_b = point();
    const Eigen::Vector3d p_cam = T_b_cam.inverse() * p_b;
    EXPECT_LT((T_a_cam.inverse() * (S_a_b * p_b) - S_a_b.scale * p_cam).norm(), 1e-9);
  }
}

TEST_F(Sim3Test, similarityAtIsWhatCarriedThePose) {
  for (int i = 0; i < 100; ++i) {
    const Sim3 S_a_b = similarity();
    Eigen::Isometry3d T_b_cam = Eigen::Isometry3d::Identity();
    T_b_cam.linear() = rotation();
    T_b_cam.translation() = point();
    const Sim3 found = similarityAt(S_a_b.scale, S_a_b.carry(T_b_cam), T_b_cam);
    EXPECT_LT((found.rotation - S_a_b.rotation).norm(), 1e-12);
    EXPECT_LT((found.translation - S_a_b.translation).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace cf
