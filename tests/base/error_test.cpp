// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/base/error.h"

#include <gtest/gtest.h>

namespace cf {
namespace {

int succeed(int, char**) { return 0; }
int failUsage(int, char**) { throw UsageError("flight.ini: no such file"); }
int failRun(int, char**) { throw RunError("out: not writable"); }
int failStrangely(int, char**) { throw RunError("a\nb\x1B[31m  c: not writable"); }
int failOther(int, char**) { throw std::logic_error("surprise"); }

struct Case {
  int (*body)(int, char**);
  int status;
  const char* line;
};

TEST(ExitStatus, followsTheContractWithOneLine) {
  for (const Case& c :
       {Case{succeed, 0, ""}, Case{failUsage, 2, "cf-x: flight.ini: no such file\n"},
        Case{failRun, 1, "cf-x: out: not writable\n"},
        Case{failStrangely, 1, "cf-x: a?b?[31m  c: not writable\n"},
        Case{failOther, 1, "cf-x: surprise\n"}}) {
    testing::internal::CaptureStderr();
    EXPECT_EQ(exitStatusOf("cf-x", c.body, 0, nullptr), c.status);
    EXPECT_EQ(testing::internal::GetCapturedStderr(), c.line);
  }
}

}  // namespace
}  // namespace cf
