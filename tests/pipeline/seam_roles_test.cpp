// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// One process for each UAV and one for the central node, with nothing but seam files between them.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <future>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "cf/formats/seam_file.h"
#include "support/synthetic_flight.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

namespace fs = std::filesystem;
using support::CommandResult;

const std::string kUavs[] = {"northA", "northB", "northC"};

class SeamRoles : public ::testing::Test {
 protected:
  SeamRoles() : config_(support::writeSyntheticFlight(folder_ / "in")), seam_(folder_ / "seam") {}

  /// The same settings for all; `where`: the configuration, which may have moved.
  std::string command(const std::string& flags, const std::string& origin = "47, -92, 150") const {
    return std::string("'" CF_BIN_DIR "/cf-run' '") + config_.string() + "' " + flags +
           (origin.empty() ? "" : " -s 'world.origin=" + origin + "'") +
           " -s view.snapshots=false -s densify.megapixels=0.1";
  }
  std::string agent(const std::string& uav) const {
    return "--role agent --uav " + uav + " --seam '" + seam_.string() + "' ";
  }
  std::string central(const std::string& outdir) const {
    return "--role central --seam '" + seam_.string() + "' -o '" + (folder_ / outdir).string() +
           "' ";
  }
  static CommandResult run(const std::string& command) { return support::runCommand(command); }

  static std::set<std::string> filesOf(const fs::path& outdir) {
    std::set<std::string> files;
    for (const auto& item : fs::recursive_directory_iterator(outdir))
      if (item.is_regular_file()) files.insert(fs::relative(item.path(), outdir).string());
    return files;
  }
  nlohmann::json report(const std::string& outdir) const {
    return nlohmann::json::parse(support::fileText(folder_ / outdir / "report.json"));
  }

  support::TempFolder folder_;
  const fs::path config_;
  const fs::path seam_;
};

/// What an agent that was killed, or ended, has left is gone on with; what does not go on with it
/// is refused.
TEST_F(SeamRoles, AnAgentGoesOnWithItsFile) {
  ASSERT_EQ(run(command(agent("northA") + "--resume")).status, 0) << "with nothing, too";
  const fs::path file = seam_ / "northA.seam";
  const std::string whole = support::fileText(file);
  for (const std::size_t size : {whole.size(), whole.size() / 2, std::size_t{20}, std::size_t{3}}) {
    fs::resize_file(file, size);
    const CommandResult r = run(command(agent("northA") + "--resume"));
    EXPECT_EQ(r.status, 0) << r.output;
    EXPECT_TRUE(support::fileText(file) == whole) << size;
  }
  const CommandResult other =
      run(command(agent("northA") + "--resume -s odometry.keyframe_features=500"));
  EXPECT_EQ(other.status, 1);
  EXPECT_NE(other.output.find("begun with other settings"), std::string::npos) << other.output;
  EXPECT_TRUE(support::fileText(file) == whole);
}

/// Every file is the same, the orthophoto too: photos this small cross as they are.
TEST_F(SeamRoles, AgentsAndCentralNodeMakeTheMapOfOneProcess) {
  const std::string whole = (folder_ / "whole").string();
  ASSERT_EQ(run(command("-o '" + whole + "'")).status, 0);
  auto followed = std::async(
      std::launch::async, [&] { return run(command(central("out") + "-s playback.wait_s=500")); });
  for (const std::string& uav : kUavs) {
    const CommandResult r = run(command(agent(uav)));
    EXPECT_EQ(r.status, 0) << r.output;
  }
  const CommandResult r = followed.get();
  ASSERT_EQ(r.status, 0) << r.output;
  // What crosses the seam holds all that the central node needs.
  fs::remove_all(folder_ / "in" / "northA_Images");
  fs::remove(folder_ / "in" / "northA.rawlog");
  const CommandResult again = run(command(central("replayed")));
  ASSERT_EQ(again.status, 0) << again.output;
  for (const char* outdir : {"out", "replayed"}) {
    ASSERT_EQ(filesOf(folder_ / outdir), filesOf(whole)) << outdir;
    for (const std::string& file : filesOf(whole))
      if (file != "report.json" && file != "report.html" && file != "config.effective.ini") {
        EXPECT_TRUE(support::fileText(folder_ / outdir / file) ==
                    support::fileText(fs::path(whole) / file))
            << outdir << ": " << file;
      }
    EXPECT_EQ(report(outdir)["bytes_over_seam"], report("whole")["bytes_over_seam"]) << outdir;
    EXPECT_EQ(report(outdir)["warnings"], report("whole")["warnings"]) << outdir;
  }
}

TEST_F(SeamRoles, OfAnAgentThatIsKilledWhatCameIsUsed) {
  for (const char* uav : {"northA", "northC"}) ASSERT_EQ(run(command(agent(uav))).status, 0);
  // One photo in ten seconds: it is killed between its second and its third.
  const std::string killed = "exec " + command(agent("northB") + "-s playback.rate=0.2");
  const pid_t process = fork();
  if (process == 0) {
    execl("/bin/sh", "sh", "-c", killed.c_str(), nullptr);
    _exit(127);
  }
  SeamReader reader(seam_ / "northB.seam");
  for (int messages = 0; messages < 3;) {
    if (reader.next())
      ++messages;
    else
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    ASSERT_EQ(waitpid(process, nullptr, WNOHANG), 0) << "it ended by itself";
  }
  kill(process, SIGKILL);
  waitpid(process, nullptr, 0);

  const CommandResult r = run(command(central("out") + "-s playback.wait_s=1"));
  ASSERT_EQ(r.status, 0) << r.output;
  const auto told = report("out");
  const std::string warning = "northB: its agent has not gone on for 1 s, after 2 of 5 photos";
  EXPECT_NE(told["warnings"].dump().find(warning), std::string::npos) << told["warnings"].dump();
  const std::string photos = support::fileText(folder_ / "out/images/northB.csv");
  EXPECT_NE(photos.find("its agent had stopped"), std::string::npos) << photos;
  for (const char* uav : {"northA", "northC"}) {
    const std::string poses =
        support::fileText(folder_ / "out/trajectories" / (uav + std::string(".tum")));
    EXPECT_EQ(std::count(poses.begin(), poses.end(), '\n'), 5) << uav;
  }
  EXPECT_GT(fs::file_size(folder_ / "out/cloud/cloud.ply"), 100'000U);
}

TEST_F(SeamRoles, AnAgentThatNeverCameIsSaid) {
  ASSERT_EQ(run(command(agent("northB"))).status, 0);
  const CommandResult r = run(command(central("out") + "-s playback.wait_s=0.5"));
  EXPECT_EQ(r.status, 0) << r.output;
  EXPECT_NE(report("out")["warnings"].dump().find("northC: no agent has written"),
            std::string::npos);
  const CommandResult refused = run(command(central("out")));
  EXPECT_EQ(refused.status, 2) << "before it waits: " << refused.output;
  fs::remove_all(seam_);
  EXPECT_EQ(run(command(central("none") + "-s playback.wait_s=0.5")).status, 1);
}

TEST_F(SeamRoles, TheWorldsOriginMustBeKnownToAll) {
  const CommandResult refused = run(command(agent("northB"), ""));
  EXPECT_EQ(refused.status, 2);
  EXPECT_NE(refused.output.find("give [world] origin"), std::string::npos) << refused.output;
  EXPECT_FALSE(fs::exists(seam_ / "northB.seam"));
  EXPECT_EQ(run(command(agent("northA"), "")).status, 0);  // the central UAV: its own first fix
  const CommandResult other = run(command(central("out") + "-s playback.wait_s=0.5", "10, 20, 30"));
  EXPECT_EQ(other.status, 1);
  EXPECT_NE(other.output.find("the same [world] origin"), std::string::npos) << other.output;
}

TEST_F(SeamRoles, WhatDoesNotBelongTogetherIsRefused) {
  const std::string seam = "--seam '" + seam_.string() + "' ";
  for (const std::string& wrong :
       {seam, std::string("--role agent --uav northA"), "--role agent " + seam,
        "--role central --uav northA " + seam, "--role pilot " + seam,
        "--role agent --uav nobody " + seam, agent("northA") + "-o out"}) {
    const CommandResult r = run(command(wrong));
    EXPECT_EQ(r.status, 2) << wrong << "\n" << r.output;
  }
  ASSERT_EQ(run(command(agent("northA"))).status, 0);
  EXPECT_EQ(run(command(agent("northA"))).status, 2) << "there is such a file already";
  EXPECT_EQ(run(command(agent("northA") + "-w")).status, 0);
  fs::copy(seam_ / "northA.seam", seam_ / "northB.seam");
  const CommandResult twice = run(command(central("out") + "-s playback.wait_s=0.5"));
  EXPECT_EQ(twice.status, 1);
  EXPECT_NE(twice.output.find("the same configuration"), std::string::npos) << twice.output;
}

}  // namespace
}  // namespace cf
