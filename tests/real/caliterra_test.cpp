// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// 75 photos of 12 MP with GPS that is junk, split into three UAVs.
#include "flight.h"

namespace cf {
namespace {

class Caliterra : public RealFlight {};

TEST_F(Caliterra, JunkGnssDoesNotBendThePath) {
  if (!have("caliterra")) return;
  import("--images " + images() + " --split 3");
  play("-s view.snapshots=false -s densify.megapixels=0.1");
  EXPECT_EQ(report_["uavs"].size(), 3u);
  EXPECT_EQ(report_["photos"]["posed"], 75);
  EXPECT_EQ(report_["components"], 1);

  const Json path = evaluate("trajectory", "--align sim3");
  EXPECT_EQ(path["matched"], 75);
  EXPECT_LT(path["rmse_over_extent"], 0.005);
}

}  // namespace
}  // namespace cf
