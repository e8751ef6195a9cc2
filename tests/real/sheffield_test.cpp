// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// 170 photos of 0.5 MP in crossing lines over a park, shared by four UAVs.
#include <algorithm>
#include <array>

#include "flight.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

class Sheffield : public RealFlight {
 protected:
  /// Links to the photos of each UAV, by file number; the arguments that name the folders.
  std::string folders() {
    constexpr std::array<std::array<int, 2>, 4> kNumbers = {
        {{54, 93}, {94, 133}, {136, 173}, {174, 225}}};
    std::string arguments;
    for (std::size_t u = 0; u < kNumbers.size(); ++u) {
      const fs::path folder = folder_ / ("s" + std::to_string(u));
      fs::create_directories(folder);
      for (const auto& item : fs::directory_iterator(data_ / "images")) {
        const int number = std::atoi(item.path().stem().string().substr(4).c_str());
        if (number >= kNumbers[u][0] && number <= kNumbers[u][1])
          fs::create_symlink(item.path(), folder / item.path().filename());
      }
      arguments += " --images '" + folder.string() + "'";
    }
    return arguments;
  }
};

TEST_F(Sheffield, MapAgreesWithTheReference) {
  if (!have("sheffield_cross")) return;
  import(folders());
  play("-s view.snapshots=false -s densify.megapixels=0.2");
  EXPECT_EQ(report_["uavs"].size(), 4u);
  EXPECT_EQ(report_["photos"]["posed"], 170);
  EXPECT_EQ(report_["components"], 1);

  const Json path = evaluate("trajectory", "--align se3");
  EXPECT_EQ(path["matched"], 170);
  EXPECT_LT(path["rmse_m"], 0.4);

  // Five ground points, each marked in photos of two UAVs or more.
  const Json points =
      evaluateWith("gcp", CF_SOURCE_DIR "/tests/real/sheffield_points.txt", "--align se3");
  EXPECT_EQ(points["triangulated"], 5);
  EXPECT_EQ(points["across_uavs"], 5);
  EXPECT_LT(points["rms_px"], 0.5);
  EXPECT_LT(points["max_px"], 1.5);
  EXPECT_LT(points["difference_m"]["horizontal_rms"], 1.0);

  const Json cloud = evaluate("cloud", "--align icp");
  EXPECT_GE(cloud["plane"]["share_within"]["1m"], 0.75);
}

}  // namespace
}  // namespace cf
