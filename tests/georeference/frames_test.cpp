// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/georeference/frames.h"

#include <gtest/gtest.h>

#include "cf/geodesy/local_frame.h"
#include "georeference/flight.h"

namespace cf {
namespace {

Sim3 randomSim3(test::Flight& draw) {
  return {std::exp(draw.normal(1)), test::rotationOf(draw.normal3(1)), draw.normal3(50)};
}

TEST(Frames, CentralLocalFromLocalGoesThroughBothEnus) {
  test::Flight draw;
  const LocalFrame w0(46.84, -91.99, 200), wk(47.10, -91.20, 350);
  const Sim3 S_w0_l0 = randomSim3(draw), S_wk_lk = randomSim3(draw);
  const Sim3 S_l0_lk = localToCentralLocal(S_w0_l0, w0.T_this_other(wk), S_wk_lk);
  for (int k = 0; k < 10; ++k) {
    const Eigen::Vector3d p_lk = draw.normal3(10);
    // The long way, through the ellipsoid.
    const Eigen::Vector3d p_w0 = w0.toEnu(wk.toGeodetic(S_wk_lk * p_lk));
    EXPECT_LT((S_w0_l0 * (S_l0_lk * p_lk) - p_w0).norm(), 1e-5);
  }
}

TEST(Frames, LeavingOutTheRotationOfTheEnusIsWrong) {
  const LocalFrame w0(46.84, -91.99, 200), wk(47.10, -91.20, 350);
  Eigen::Isometry3d without = w0.T_this_other(wk);
  without.linear().setIdentity();
  const Sim3 unit;
  const Eigen::Vector3d p(1000, 0, 0);
  EXPECT_GT((localToCentralLocal(unit, without, unit) * p -
             localToCentralLocal(unit, w0.T_this_other(wk), unit) * p)
                .norm(),
            1);
}

}  // namespace
}  // namespace cf
