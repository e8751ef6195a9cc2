// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// Runs that are killed at any moment and resumed end as if nothing had been. CF_KILLS=100 asks for
// more kills, CF_KILL_CONFIG=FILE for another flight.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <random>
#include <set>
#include <thread>

#include "support/process.h"
#include "support/synthetic_flight.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

namespace fs = std::filesystem;
using support::CommandResult;

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

class Interruption : public ::testing::Test {
 protected:
  /// cf-run in a process of its own; killed after so many seconds, if above 0.
  CommandResult run(const fs::path& outdir, const std::string& flags, double kill_after_s) const {
    const std::string limit =
        kill_after_s > 0 ? "timeout -s KILL " + std::to_string(kill_after_s) + " " : "";
    return support::runCommand("sh -c '" + limit + CF_BIN_DIR "/cf-run \"" + config_.string() +
                               "\" -o \"" + outdir.string() + "\" " + flags +
                               " -s view.snapshots=false -s densify.megapixels=0.1'");
  }
  /// Relative paths of what a run has written, but what tells of its time.
  static std::set<std::string> results(const fs::path& outdir) {
    std::set<std::string> files;
    for (const auto& item : fs::recursive_directory_iterator(outdir)) {
      const std::string name = item.path().filename().string();
      if (item.is_regular_file() && name != "report.json" && name != "report.html")
        files.insert(fs::relative(item.path(), outdir).string());
    }
    return files;
  }

  support::TempFolder folder_;
  fs::path config_;
};

TEST_F(Interruption, KilledAtAnyMomentAndResumedItEndsTheSame) {
  const char* other = std::getenv("CF_KILL_CONFIG");
  config_ = other ? fs::path(other) : support::writeSyntheticFlight(folder_ / "in");
  const char* kills = std::getenv("CF_KILLS");
  const int most = kills ? std::atoi(kills) : 5;
  const fs::path whole = folder_ / "whole", broken = folder_ / "broken";
  const double started = now();
  ASSERT_EQ(run(whole, "", 0).status, 0);
  const double lasts_s = now() - started;

  std::mt19937 random(7);
  for (int killed = 0; killed < most;) {
    // A few kills, one after the other, then to the end.
    for (int k = 0; k < 3 && killed < most; ++k) {
      const double after = std::uniform_real_distribution<double>(0.02, 1.0)(random) * lasts_s;
      if (run(broken, "--resume", after).status != 0) ++killed;
    }
    const CommandResult r = run(broken, "--resume", 0);
    ASSERT_EQ(r.status, 0) << r.output;
    ASSERT_EQ(results(broken), results(whole));
    for (const std::string& file : results(whole))
      ASSERT_TRUE(support::fileText(whole / file) == support::fileText(broken / file)) << file;
    EXPECT_EQ(run(broken, "--resume", 0).status, 0) << "a finished run has nothing to resume";
    fs::remove_all(broken);
  }
}

TEST_F(Interruption, AnInterruptedRunIsNeitherTakenForAResultNorForAnotherRun) {
  config_ = support::writeSyntheticFlight(folder_ / "in");
  const fs::path out = folder_ / "out";
  for (double after = 0.5; !fs::exists(out / ".cf-run/run.txt"); after *= 1.5) {
    fs::remove_all(out);
    ASSERT_NE(run(out, "", after).status, 0);
  }
  const CommandResult again = run(out, "", 0);
  EXPECT_EQ(again.status, 2);
  EXPECT_NE(again.output.find("--resume"), std::string::npos) << again.output;
  const CommandResult different = run(out, "--resume -s densify.partners=1", 0);
  EXPECT_EQ(different.status, 2);
  EXPECT_NE(different.output.find("'partners = 2' then, 'partners = 1' now"), std::string::npos)
      << different.output;
  EXPECT_EQ(run(out, "-w", 0).status, 0);
  EXPECT_FALSE(fs::exists(out / ".cf-run"));
}

/// Ctrl-C at a moment at which there is something to keep, and before.
TEST_F(Interruption, CtrlCSaysWhatIsKeptAndHowToGoOn) {
  config_ = support::writeSyntheticFlight(folder_ / "in");
  const fs::path whole = folder_ / "whole", broken = folder_ / "broken", log = folder_ / "log";
  ASSERT_EQ(run(whole, "", 0).status, 0);
  const std::vector<std::string> command = {CF_BIN_DIR "/cf-run",
                                            config_.string(),
                                            "-o",
                                            broken.string(),
                                            "-s",
                                            "view.snapshots=false",
                                            "-s",
                                            "densify.megapixels=0.1"};
  for (const int number : {SIGINT, SIGTERM}) {
    support::Process running(command, log);
    while (!fs::exists(broken / ".cf-run/photos/0_1.jpg") && running.running())
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    running.signal(number);
    EXPECT_EQ(running.wait(), 130);
    const std::string said = support::fileText(log);
    EXPECT_NE(said.find("cf-run: interrupted: " + broken.string() +
                        " keeps what was done; the same command with --resume goes on\n"),
              std::string::npos)
        << said;
    const CommandResult resumed = run(broken, "--resume", 0);
    ASSERT_EQ(resumed.status, 0) << resumed.output;
    ASSERT_EQ(results(broken), results(whole));
    for (const std::string& file : results(whole))
      EXPECT_TRUE(support::fileText(whole / file) == support::fileText(broken / file)) << file;
    fs::remove_all(broken);
  }
  // A flight to be followed that has not begun.
  std::vector<std::string> waiting = command;
  waiting.insert(waiting.end(), {"-s", "playback.follow_s=3600"});
  fs::remove(folder_ / "in/northA.rawlog");
  fs::remove(folder_ / "in/northB.rawlog");
  fs::remove(folder_ / "in/northC.rawlog");
  support::Process running(waiting, log);
  while (support::fileText(log).find("waiting for the first photos") == std::string::npos &&
         running.running())
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  running.signal(SIGINT);
  EXPECT_EQ(running.wait(), 130);
  EXPECT_NE(support::fileText(log).find("cf-run: interrupted: nothing was written yet\n"),
            std::string::npos);
  EXPECT_FALSE(fs::exists(broken));
}

}  // namespace
}  // namespace cf
