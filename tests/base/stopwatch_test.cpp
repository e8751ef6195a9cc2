// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/base/stopwatch.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>
#include <vector>

namespace cf {
namespace {

TEST(StageTimes, sumsTheScopesOfEachStage) {
  StageTimes times;
  for (int i = 0; i < 3; ++i) {
    const StageTimes::Scope scope(times, "densify");
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  { const StageTimes::Scope scope(times, "fuse"); }
  const auto all = times.all();
  ASSERT_EQ(all.size(), 2U);
  EXPECT_GE(all.at("densify").wall_s, 0.015);
  EXPECT_GE(all.at("fuse").wall_s, 0);
  EXPECT_GE(all.at("densify").cpu_s, 0);
}

TEST(StageTimes, countsBusyTimeAsCpuTime) {
  StageTimes times;
  {
    const StageTimes::Scope scope(times, "busy");
    const double begin = processCpuSeconds();
    while (processCpuSeconds() - begin < 0.02) {
    }
  }
  EXPECT_GE(times.all().at("busy").cpu_s, 0.02);
}

TEST(PeakRss, growsWithWhatIsTouched) {
  const double before = peakRssMegabytes();
  const std::vector<char> block(64U << 20U, 1);
  EXPECT_EQ(block.back(), 1);
  EXPECT_GE(peakRssMegabytes(), 64);
  EXPECT_GE(peakRssMegabytes(), before);
}

}  // namespace
}  // namespace cf
