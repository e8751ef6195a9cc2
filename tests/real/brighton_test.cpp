// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// 18 photos of 9 MP over a road loop, three strips as three UAVs.
#include "flight.h"

namespace cf {
namespace {

class Brighton : public RealFlight {};

TEST_F(Brighton, MapAgreesWithTheReference) {
  if (!have("brighton_beach")) return;
  import("--images " + images() + " --split strips");
  play("-s view.snapshots=false");
  EXPECT_EQ(report_["uavs"].size(), 3u);
  EXPECT_EQ(report_["photos"]["posed"], 18);
  EXPECT_EQ(report_["components"], 1);

  const Json path = evaluate("trajectory", "--align se3");
  EXPECT_EQ(path["matched"], 18);
  EXPECT_LT(path["rmse_m"], 0.4);

  const Json cloud = evaluate("cloud", "--align icp");
  EXPECT_GE(cloud["plane"]["share_within"]["0.5m"], 0.88);
  EXPECT_GE(cloud["plane"]["share_within"]["1m"], 0.95);
}

}  // namespace
}  // namespace cf
