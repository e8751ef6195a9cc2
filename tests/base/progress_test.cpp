// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/base/progress.h"

#include <gtest/gtest.h>

#include <string>

namespace cf {
namespace {

// stderr is no terminal while it is captured.

TEST(Progress, endsWithOnePlainLine) {
  testing::internal::CaptureStderr();
  {
    Progress progress("photos", 3);
    for (int i = 0; i < 3; ++i) progress.advance("scale 1.2");
  }
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_EQ(said.rfind("photos 3/3  ", 0), 0U) << said;
  EXPECT_EQ(said.find('\n'), said.size() - 1) << said;
  EXPECT_EQ(said.find('\r'), std::string::npos) << said;
}

TEST(Progress, saysNothingWhereNothingWasDone) {
  testing::internal::CaptureStderr();
  { const Progress progress("photos", 0); }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace cf
