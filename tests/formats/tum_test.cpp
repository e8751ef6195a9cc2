// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/tum.h"

#include <gtest/gtest.h>

#include "cf/base/error.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

class Tum : public ::testing::Test {
 protected:
  fs::path fileWith(const std::string& content) const {
    support::writeText(folder_ / "read.tum", content);
    return folder_ / "read.tum";
  }

  support::TempFolder folder_;
};

TEST_F(Tum, TimesAreExactAndPosesReturn) {
  const fs::path path = folder_ / "written.tum";
  std::vector<TimedPose> poses(3);
  for (int i = 0; i < 3; ++i) {
    auto& pose = poses[static_cast<std::size_t>(i)];
    pose.time = 1466699519'123456789 + i;
    pose.T_world_cam.translate(Eigen::Vector3d(1000.125 * i, -2, 0.5));
    pose.T_world_cam.rotate(Eigen::AngleAxisd(1.4 * i, Eigen::Vector3d(1, 2, 3).normalized()));
  }
  writeTum(path, poses);
  const std::vector<TimedPose> read = readTum(path);
  ASSERT_EQ(read.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(read[i].time, poses[i].time);
    EXPECT_TRUE(read[i].T_world_cam.isApprox(poses[i].T_world_cam, 1e-8));
  }
}

TEST_F(Tum, CommentsFewDigitsAndLongQuaternions) {
  const auto read = readTum(fileWith("# head\n5.25 1 2 3 0 0 0 1.001\r\n\n7 0 0 0 0.6 0 0 -0.8\n"));
  ASSERT_EQ(read.size(), 2u);
  EXPECT_EQ(read[0].time, 5'250'000'000);
  EXPECT_EQ(read[0].T_world_cam.translation(), Eigen::Vector3d(1, 2, 3));
  EXPECT_TRUE(read[0].T_world_cam.linear().isIdentity(1e-12));
  EXPECT_EQ(read[1].time, 7'000'000'000);
}

TEST_F(Tum, BadLinesAreNamed) {
  for (const char* line : {"5 1 2 3 0 0 0", "5 1 2 3 0 0 0 1 9", "x 1 2 3 0 0 0 1",
                           "5 1 2 3 0 0 0 0", "5 1 2 z 0 0 0 1"}) {
    try {
      static_cast<void>(readTum(fileWith(std::string("#\n") + line + "\n")));
      FAIL() << "must throw on " << line;
    } catch (const RunError& e) {
      EXPECT_NE(std::string(e.what()).find("read.tum: line 2"), std::string::npos) << e.what();
    }
  }
  EXPECT_THROW(static_cast<void>(readTum("/nonexistent.tum")), RunError);
}

}  // namespace
}  // namespace cf
