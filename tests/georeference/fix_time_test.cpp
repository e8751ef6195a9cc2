// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "georeference/flight.h"

namespace cf {
namespace {

GnssFix fixAt(double t_s, const Eigen::Vector3d& p, double sigma = 1) {
  GnssFix fix;
  fix.time = static_cast<TimeNs>(t_s * 1e9);
  fix.longitude_deg = p.x();
  fix.latitude_deg = p.y();
  fix.height_m = p.z();
  fix.sigma_enu_m.setConstant(sigma);
  return fix;
}

std::shared_ptr<const Keyframe> photoAt(double t_s, std::uint32_t index) {
  auto keyframe = std::make_shared<Keyframe>();
  keyframe->id = {0, index};
  keyframe->time = static_cast<TimeNs>(t_s * 1e9);
  keyframe->T_local_cam.translation().x() = t_s;
  keyframe->T_local_cam.linear() = Eigen::DiagonalMatrix<double, 3>(1, -1, -1).toDenseMatrix();
  return keyframe;
}

TEST(FixTime, InterpolatesLinearlyAndGrowsSigmaBetweenFixes) {
  GeoreferenceOptions options;
  options.acceleration_sigma_mps2 = 0.5;
  Georeferencer stage(0, options, test::metresAsDegrees);
  stage.addFix(fixAt(10, {0, 0, 50}));
  stage.addFix(fixAt(14, {8, 4, 54}));
  const auto out = stage.push(photoAt(11, 0));
  ASSERT_EQ(out.size(), 1u);
  ASSERT_TRUE(out[0].fix);
  EXPECT_LT((out[0].fix->position_m - Eigen::Vector3d(2, 1, 51)).norm(), 1e-9);
  const double bow = 0.5 * 0.25 * 0.75 * 16 / 2;
  EXPECT_NEAR(out[0].fix->sigma_m.x(), std::sqrt(0.75 * 0.75 + 0.25 * 0.25 + bow * bow), 1e-9);
}

TEST(FixTime, FixOfThePhotoItselfIsTakenAsItIs) {
  Georeferencer stage(0, {}, test::metresAsDegrees);
  stage.addFix(fixAt(10, {1, 2, 3}, 0.5));
  const auto out = stage.push(photoAt(10, 0));
  ASSERT_EQ(out.size(), 1u);
  EXPECT_EQ(out[0].fix->position_m, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(out[0].fix->sigma_m, Eigen::Vector3d::Constant(0.5));
}

TEST(FixTime, WaitsForTheLaterFix) {
  Georeferencer stage(0, {}, test::metresAsDegrees);
  stage.addFix(fixAt(10, {0, 0, 0}));
  EXPECT_TRUE(stage.push(photoAt(11, 0)).empty());
  EXPECT_TRUE(stage.push(photoAt(11.5, 1)).empty());
  stage.addFix(fixAt(12, {2, 0, 0}));
  const auto out = stage.push(photoAt(13, 2));
  ASSERT_EQ(out.size(), 2u);
  EXPECT_NEAR(out[0].fix->position_m.x(), 1, 1e-9);
  EXPECT_NEAR(out[1].fix->position_m.x(), 1.5, 1e-9);
  const auto rest = stage.flush();
  ASSERT_EQ(rest.size(), 1u);
  EXPECT_FALSE(rest[0].fix);
}

TEST(FixTime, NoneAcrossAnOutageOrOutsideTheFixes) {
  GeoreferenceOptions options;
  options.max_gap_s = 5;
  Georeferencer stage(0, options, test::metresAsDegrees);
  stage.addFix(fixAt(10, {0, 0, 0}));
  stage.addFix(fixAt(16, {6, 0, 0}));
  auto out = stage.push(photoAt(9, 0));
  ASSERT_EQ(out.size(), 1u);
  EXPECT_FALSE(out[0].fix);
  out = stage.push(photoAt(12, 1));
  ASSERT_EQ(out.size(), 1u);
  EXPECT_FALSE(out[0].fix);
}

}  // namespace
}  // namespace cf
