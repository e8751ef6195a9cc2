// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "memory_plan.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/parallel_pipeline.h>

#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "memory_gate.h"
#include "support/synthetic_flight.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

RunOptions twoThreads(int limit_mb) {
  RunOptions options;
  options.uavs.resize(3);
  options.system.threads = 2;
  options.system.max_memory_mb = limit_mb;
  return options;
}

constexpr FlightSize kFlight{75, 12};

TEST(MemoryPlan, WithoutNeedNothingIsSaved) {
  const RunOptions options = twoThreads(16'000);
  const MemoryPlan plan = planMemory(options, kFlight);
  EXPECT_EQ(plan.limit_mb, 16'000);
  EXPECT_EQ(plan.steps_in_flight, 16U);
  EXPECT_EQ(plan.photos_in_memory, 12U);
  EXPECT_EQ(plan.photos_matched, 3U);
  EXPECT_EQ(plan.tile_mb, options.fuse.max_memory_mb);
  EXPECT_EQ(plan.crops_mb, 300);
  EXPECT_TRUE(plan.side_by_side);
  EXPECT_EQ(objectionTo(plan, options, kFlight), "");
}

TEST(MemoryPlan, LessMemoryNeverMeansMoreAtOnce) {
  MemoryPlan before = planMemory(twoThreads(16'000), kFlight);
  for (int limit_mb = 4000; limit_mb >= 100; limit_mb -= 20) {
    const MemoryPlan plan = planMemory(twoThreads(limit_mb), kFlight);
    EXPECT_LE(plan.steps_in_flight, before.steps_in_flight) << limit_mb;
    EXPECT_LE(plan.photos_in_memory, before.photos_in_memory) << limit_mb;
    EXPECT_LE(plan.tile_mb, before.tile_mb) << limit_mb;
    EXPECT_LE(plan.side_by_side, before.side_by_side) << limit_mb;
    EXPECT_GE(plan.steps_in_flight, 1U);
    EXPECT_GE(plan.photos_matched, 1U);
    EXPECT_EQ(plan.least_mb, before.least_mb);
    before = plan;
  }
  EXPECT_FALSE(before.side_by_side);
}

TEST(MemoryPlan, WhatIsToldOfTilesIsNotExceeded) {
  RunOptions options = twoThreads(16'000);
  options.fuse.max_memory_mb = 20;
  EXPECT_EQ(planMemory(options, kFlight).tile_mb, 20);
}

TEST(MemoryPlan, AFlightThatDoesNotFitIsSaidWithWhatItNeeds) {
  const RunOptions options = twoThreads(200);
  const MemoryPlan plan = planMemory(options, kFlight);
  EXPECT_GT(plan.least_mb, 300);
  const std::string line = objectionTo(plan, options, kFlight);
  EXPECT_NE(line.find("75 photos of 12 MP"), std::string::npos) << line;
  EXPECT_NE(line.find("more than the 200 MB"), std::string::npos) << line;
  RunOptions smaller = options;
  smaller.view.snapshots = false;
  EXPECT_LT(planMemory(smaller, kFlight).least_mb, plan.least_mb);
}

/// However little it is: with one thread and with several, in order and with loops inside.
TEST(MemoryGate, NeverStopsAPipeline) {
  for (const int threads : {1, 2, 4}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(threads));
    MemoryGate gate(1);
    int next = 0, done = 0;
    tbb::parallel_pipeline(
        4, tbb::make_filter<void, int>(tbb::filter_mode::serial_in_order, [&](tbb::flow_control&
                                                                                  control) {
             if (next == 20) {
               control.stop();
               return 0;
             }
             gate.enter();
             return ++next;
           }) & tbb::make_filter<int, int>(tbb::filter_mode::parallel, [&](int i) {
             std::this_thread::sleep_for(std::chrono::milliseconds(5));
             return i;
           }) & tbb::make_filter<int, void>(tbb::filter_mode::serial_in_order, [&](int) {
             ++done;
             gate.leave();
           }));
    EXPECT_EQ(done, 20) << threads;
  }
}

/// The demo's flight: the same files, in less memory.
TEST(MaxMemory, IsKeptAndChangesNothing) {
  const support::TempFolder folder;
  const auto run = [&](const std::string& outdir, const std::string& flags) {
    return support::runCommand("'" CF_BIN_DIR "/cf-run' '" CF_SOURCE_DIR "/config.ini' -o '" +
                               (folder / outdir).string() +
                               "' -s view.snapshots=false -s system.threads=4 " + flags);
  };
  const auto report = [&](const std::string& outdir) {
    return nlohmann::json::parse(support::fileText(folder / outdir / "report.json"));
  };
  const auto refused = run("out", "-s system.max_memory_mb=150");
  EXPECT_EQ(refused.status, 2) << refused.output;
  EXPECT_NE(refused.output.find("need about"), std::string::npos) << refused.output;
  EXPECT_FALSE(fs::exists(folder / "out"));

  ASSERT_EQ(run("whole", "").status, 0);
  constexpr int kLimit_mb = 420;
  const auto tight = run("tight", "-s system.max_memory_mb=" + std::to_string(kLimit_mb));
  ASSERT_EQ(tight.status, 0) << tight.output;
  EXPECT_GT(report("whole")["peak_rss_mb"].get<double>(), kLimit_mb) << "else it shows nothing";
  EXPECT_LE(report("tight")["peak_rss_mb"].get<double>(), kLimit_mb);
  std::set<std::string> files;
  for (const auto& item : fs::recursive_directory_iterator(folder / "whole"))
    if (item.is_regular_file()) files.insert(fs::relative(item.path(), folder / "whole").string());
  for (const std::string& file : files)
    if (file != "report.json" && file != "report.html" && file != "config.effective.ini") {
      EXPECT_TRUE(support::fileText(folder / "whole" / file) ==
                  support::fileText(folder / "tight" / file))
          << file;
    }
}

}  // namespace
}  // namespace cf
