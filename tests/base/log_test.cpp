// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/base/log.h"

#include <gtest/gtest.h>

namespace cf {
namespace {

TEST(Log, writesOneLineEachToStderr) {
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  logInfo("18 photos, 100 % {} %s");
  logWarning("a.jpg is damaged");
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "18 photos, 100 % {} %s\nwarning: a.jpg is damaged\n");
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
}

TEST(Log, quietKeepsWarnings) {
  setLogQuiet(true);
  testing::internal::CaptureStderr();
  logInfo("hidden");
  logWarning("shown");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "warning: shown\n");
  setLogQuiet(false);
  testing::internal::CaptureStderr();
  logInfo("back");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "back\n");
}

}  // namespace
}  // namespace cf
