// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/camera_ini.h"

#include <gtest/gtest.h>

#include "cf/base/error.h"
#include "support/message_of.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

class CameraIni : public ::testing::Test {
 protected:
  CameraModel camera(const std::string& text) {
    support::writeText(path_, text);
    return readCameraIni(path_);
  }

  support::TempFolder folder_;
  const std::filesystem::path path_ = folder_ / "camera.ini";
};

TEST_F(CameraIni, ReadsWhatIsGivenAndFillsTheRest) {
  const CameraModel c = camera(
      "\xEF\xBB\xBF[before]\nfx = 1\n[camera]\nwidth = 4000\nheight=3000 ; px\nfx = "
      "2904.5\nk1=-0.01\n"
      "focal_sigma = 10\n");
  EXPECT_EQ(c.width, 4000);
  EXPECT_EQ(c.fx, 2904.5);
  EXPECT_EQ(c.fy, 2904.5);
  EXPECT_EQ(c.cx, 1999.5);
  EXPECT_EQ(c.k1, -0.01);
  EXPECT_EQ(c.focal_sigma, 10);
  EXPECT_EQ(c.k1_sigma, 0);
}

TEST_F(CameraIni, ErrorsNameTheKey) {
  EXPECT_NE(support::messageOf<UsageError>([&] {
              camera("[camera]\nwidth=4\nheight=3\n");
            }).find("needs fx"),
            std::string::npos);
  EXPECT_NE(support::messageOf<UsageError>([&] {
              camera("[camera]\nwidth=4\nheight=3\nfx=4\nfocal=3\n");
            }).find("no key focal"),
            std::string::npos);
  EXPECT_NE(
      support::messageOf<UsageError>([&] { camera("[camera]\nwidth=4x\n"); }).find("camera.ini:2"),
      std::string::npos);
  EXPECT_NE(support::messageOf<UsageError>([&] { camera(""); }).find("needs width"),
            std::string::npos);
  EXPECT_NE(support::messageOf<UsageError>([&] {
              camera("[camera]\nwidth=4.5\n");
            }).find("width = 4.5 is not a whole"),
            std::string::npos);
}

}  // namespace
}  // namespace cf
