// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>

#include "cf/densify/densify.h"
#include "support/stereo_scene.h"

namespace cf {
namespace {

using support::cameraAt;
using support::distortedCamera;

DenseView viewAt(std::uint32_t index, double x, double y, double pitch = 0, double z = 50) {
  DenseView view;
  view.id = {0, index};
  const PosedCamera camera = cameraAt(distortedCamera(), x, y, z, 0, pitch);
  view.T_world_cam = camera.T_world_cam;
  view.camera = camera.camera;
  view.near_depth_m = z - 5;
  view.median_depth_m = z;
  view.far_depth_m = z + 2;
  return view;
}

DensifyOptions withPartners(int partners) {
  DensifyOptions options;
  options.partners = partners;
  return options;
}

// The photo covers 61 m x 46 m.
TEST(Partners, prefersALongEnoughBaselineOverMoreOverlap) {
  const auto chosen = choosePartners(
      viewAt(0, 0, 0), {viewAt(1, 1, 0), viewAt(2, 3, 0), viewAt(3, 12, 0)}, withPartners(1));
  ASSERT_EQ(chosen.size(), 1U);
  EXPECT_EQ(chosen[0].index, 3U);
}

TEST(Partners, takesASmallOverlapWhereTheFlightHasNoLarger) {
  // 63 % forward overlap: baseline over depth 0.34; and one of 45 %, 0.51.
  EXPECT_EQ(choosePartners(viewAt(0, 0, 0), {viewAt(1, 0, 17)}, withPartners(2)).size(), 1U);
  EXPECT_EQ(choosePartners(viewAt(0, 0, 0), {viewAt(1, 0, 25.5)}, withPartners(2)).size(), 1U);
}

TEST(Partners, theSecondCoversWhatTheFirstDoesNot) {
  // Before and behind in the strip rather than two before.
  const auto chosen = choosePartners(
      viewAt(5, 0, 0), {viewAt(6, 0, 15), viewAt(7, 1, 16), viewAt(4, 0, -15.5)}, withPartners(2));
  ASSERT_EQ(chosen.size(), 2U);
  EXPECT_TRUE(std::any_of(chosen.begin(), chosen.end(), [](FrameId id) { return id.index == 4; }));
}

TEST(Partners, refusesWhatCannotBeMatched) {
  DenseView no_depth = viewAt(6, 10, 0);
  no_depth.median_depth_m = 0;
  const std::vector<DenseView> others = {viewAt(0, 12, 0),        // itself
                                         viewAt(1, 0.2, 0),       // no baseline
                                         viewAt(2, 60, 0),        // no overlap
                                         viewAt(3, 12, 0, 0.9),   // looks elsewhere
                                         viewAt(4, 4, 0, 0, 25),  // along the optical axis
                                         no_depth};
  EXPECT_TRUE(choosePartners(viewAt(0, 0, 0), others, withPartners(8)).empty());
  EXPECT_TRUE(choosePartners(no_depth, {viewAt(0, 0, 0)}, withPartners(8)).empty());
}

TEST(Partners, doesNotDependOnTheOrderGiven) {
  std::vector<DenseView> others;
  for (std::uint32_t k = 1; k < 12; ++k) {
    others.push_back(viewAt(k, 14.0 * (k % 3) - 14, 12.0 * (k / 3) - 18));
  }
  const auto forward = choosePartners(viewAt(0, 0, 0), others, withPartners(4));
  std::reverse(others.begin(), others.end());
  EXPECT_EQ(forward, choosePartners(viewAt(0, 0, 0), others, withPartners(4)));
  EXPECT_EQ(forward.size(), 4U);
}

}  // namespace
}  // namespace cf
