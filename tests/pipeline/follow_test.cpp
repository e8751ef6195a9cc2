// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// Rawlogs that are still being written, UAVs that start late, photos on their way.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <deque>
#include <future>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <thread>

#include "cf/formats/seam_file.h"
#include "support/process.h"
#include "support/synthetic_flight.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

namespace fs = std::filesystem;
using support::CommandResult;

const std::string kUavs[] = {"northA", "northB", "northC"};

void pauseFor(double s) { std::this_thread::sleep_for(std::chrono::duration<double>(s)); }

class FollowedFlight : public ::testing::Test {
 protected:
  FollowedFlight() : config_(support::writeSyntheticFlight(folder_ / "in")) {
    fs::create_directories(live_);
    fs::copy(config_, live_ / "config.ini");
  }

  /// Without an output folder: an agent's.
  CommandResult run(const fs::path& config, const std::string& outdir,
                    const std::string& flags) const {
    return support::runCommand("'" CF_BIN_DIR "/cf-run' '" + config.string() + "'" +
                               (outdir.empty() ? "" : " -o '" + (folder_ / outdir).string() + "'") +
                               " -s view.snapshots=false -s densify.megapixels=0.1 " + flags);
  }
  /// What is not there yet is waited for as long as it takes.
  CommandResult follow(const std::string& outdir, const std::string& flags = {}) const {
    return run(live_ / "config.ini", outdir,
               "-s playback.follow_s=600 -s playback.hold_up_s=600 " + flags);
  }
  static std::string rawlogOf(const std::string& uav) { return uav + ".rawlog"; }
  static std::string imagesOf(const std::string& uav) { return uav + "_Images"; }
  void bring(const std::string& name) const {
    fs::copy(folder_ / "in" / name, live_ / name, fs::copy_options::recursive);
  }
  nlohmann::json report(const std::string& outdir) const {
    return nlohmann::json::parse(support::fileText(folder_ / outdir / "report.json"));
  }
  static std::set<std::string> filesOf(const fs::path& outdir) {
    std::set<std::string> files;
    for (const auto& item : fs::recursive_directory_iterator(outdir))
      if (item.is_regular_file()) files.insert(fs::relative(item.path(), outdir).string());
    return files;
  }
  void expectSameResults(const fs::path& a, const fs::path& b) const {
    ASSERT_EQ(filesOf(a), filesOf(b));
    for (const std::string& file : filesOf(a))
      if (file != "report.json" && file != "report.html" && file != "config.effective.ini") {
        EXPECT_TRUE(support::fileText(a / file) == support::fileText(b / file)) << file;
      }
  }

  support::TempFolder folder_;
  const fs::path config_, live_ = folder_ / "live";
};

/// A file that comes in pieces of random sizes.
class Trickle {
 public:
  Trickle(const fs::path& from, fs::path to, std::size_t largest)
      : bytes_(support::fileText(from)), to_(std::move(to)), largest_(largest) {}
  bool done() const { return at_ == bytes_.size(); }
  void next(std::mt19937& random) {
    const std::size_t size = std::min(
        bytes_.size() - at_, std::uniform_int_distribution<std::size_t>(1, largest_)(random));
    fs::create_directories(to_.parent_path());
    std::ofstream(to_, std::ios::binary | std::ios::app)
        .write(bytes_.data() + at_, static_cast<std::streamsize>(size));
    at_ += size;
  }

 private:
  std::string bytes_;
  fs::path to_;
  std::size_t largest_, at_ = 0;
};

/// Photos come after, while and before their records do; northC starts when the others have ended.
TEST_F(FollowedFlight, GivesWhatTheCompleteRawlogsGive) {
  ASSERT_EQ(run(config_, "whole", "").status, 0);
  auto followed = std::async(std::launch::async, [&] { return follow("out"); });
  std::mt19937 random(3);
  const auto bringUavs = [&](const std::vector<std::string>& uavs) {
    std::vector<Trickle> files;
    for (const std::string& uav : uavs) {
      files.emplace_back(folder_ / "in" / rawlogOf(uav), live_ / rawlogOf(uav), 60);
      for (const auto& image : fs::directory_iterator(folder_ / "in" / imagesOf(uav)))
        files.emplace_back(image.path(), live_ / imagesOf(uav) / image.path().filename(), 100'000);
    }
    while (!files.empty()) {
      const auto i = std::uniform_int_distribution<std::size_t>(0, files.size() - 1)(random);
      files[i].next(random);
      if (files[i].done()) files.erase(files.begin() + static_cast<std::ptrdiff_t>(i));
      pauseFor(0.02);
    }
  };
  bringUavs({"northA", "northB"});
  pauseFor(1);
  bringUavs({"northC"});
  const CommandResult r = followed.get();
  ASSERT_EQ(r.status, 0) << r.output;
  expectSameResults(folder_ / "out", folder_ / "whole");
  const auto out = report("out"), whole = report("whole");
  EXPECT_EQ(out["bytes_over_seam"], whole["bytes_over_seam"]);
  EXPECT_EQ(out["photos"], whole["photos"]);
  EXPECT_EQ(out["warnings"].dump().find("rawlog"), std::string::npos) << out["warnings"];
}

/// Agents follow their rawlogs, the central node their files, all at once; northA's agent is killed
/// on its way and goes on.
TEST_F(FollowedFlight, AgentsThatFollowAndACentralNodeGiveWhatOneProcessGives) {
  const std::string shared = "-s 'world.origin=47, -92, 150' ";
  ASSERT_EQ(run(config_, "whole", shared).status, 0);
  const std::string seam = (folder_ / "seam").string();
  const auto settings = [&](const std::string& role) {
    return std::vector<std::string>{CF_BIN_DIR "/cf-run",
                                    (live_ / "config.ini").string(),
                                    "--role",
                                    role,
                                    "--seam",
                                    seam,
                                    "-s",
                                    "world.origin=47, -92, 150",
                                    "-s",
                                    "view.snapshots=false",
                                    "-s",
                                    "densify.megapixels=0.1",
                                    "-s",
                                    "playback.follow_s=600",
                                    "-s",
                                    "playback.hold_up_s=600"};
  };
  const auto agent = [&](const std::string& uav, const std::string& more = {}) {
    std::vector<std::string> command = settings("agent");
    command.insert(command.end(), {"--uav", uav});
    if (!more.empty()) command.push_back(more);
    return command;
  };
  std::vector<std::string> central = settings("central");
  central.insert(central.end(), {"-o", (folder_ / "out").string()});
  support::Process centre(central, folder_ / "centre.log");
  support::Process north_b(agent("northB"), folder_ / "northB.log");
  support::Process north_c(agent("northC"), folder_ / "northC.log");
  for (const std::string& uav : kUavs) bring(imagesOf(uav));
  const auto& uavs = support::syntheticFlight().uavs;
  std::deque<RawlogWriter> rawlogs;
  for (const std::string& uav : kUavs)
    rawlogs.emplace_back(live_ / rawlogOf(uav), RawlogLabels{"CAMERA", "GPS"},
                         RawlogWriter::Visible::kAtOnce);
  const auto fly = [&](std::size_t photo) {
    for (std::size_t u = 0; u < rawlogs.size(); ++u) {
      rawlogs[u].write(support::frameOf(uavs[u].photos[photo], live_ / rawlogOf(kUavs[u])));
      rawlogs[u].write(uavs[u].photos[photo].fix);
      rawlogs[u].flush();
    }
  };
  {
    support::Process north_a(agent("northA"), folder_ / "northA.log");
    for (std::size_t photo = 0; photo < 4; ++photo) fly(photo);
    SeamReader reader(folder_ / "seam/northA.seam");
    for (int messages = 0; messages < 3 && north_a.running(); pauseFor(0.02))
      if (reader.next()) ++messages;
    north_a.signal(SIGKILL);
    EXPECT_EQ(north_a.wait(), -1) << support::fileText(folder_ / "northA.log");
  }
  support::Process north_a(agent("northA", "--resume"), folder_ / "northA.log");
  fly(4);
  for (RawlogWriter& rawlog : rawlogs) rawlog.finish();
  for (support::Process* process : {&north_a, &north_b, &north_c, &centre})
    EXPECT_EQ(process->wait(), 0) << support::fileText(folder_ / "northA.log")
                                  << support::fileText(folder_ / "centre.log");
  expectSameResults(folder_ / "out", folder_ / "whole");
  EXPECT_EQ(report("out")["bytes_over_seam"], report("whole")["bytes_over_seam"]);
}

/// A seam file that is followed, of an agent that starts late and of one that never does.
TEST_F(FollowedFlight, AnAgentThatStartsLateOrNeverBlocksNobody) {
  const std::string origin =
      "-s 'world.origin=47, -92, 150' --seam '" + (folder_ / "seam").string() + "' --role ";
  for (const char* uav : {"northA", "northB"}) {
    bring(imagesOf(uav));
    bring(rawlogOf(uav));
  }
  ASSERT_EQ(run(live_ / "config.ini", "", origin + "agent --uav northB").status, 0);
  auto followed = std::async(std::launch::async, [&] {
    return run(live_ / "config.ini", "out",
               origin +
                   "central -s playback.follow_s=3 -s playback.wait_s=3 "
                   "-s playback.hold_up_s=0.5");
  });
  while (!fs::exists(folder_ / "out/.cf-run/photos/1_4.jpg") &&
         followed.wait_for(std::chrono::milliseconds(20)) != std::future_status::ready) {
  }
  ASSERT_EQ(run(live_ / "config.ini", "", origin + "agent --uav northA").status, 0);
  const CommandResult r = followed.get();
  ASSERT_EQ(r.status, 0) << r.output;
  for (const char* uav : {"northA", "northB"})
    EXPECT_EQ(report("out")["uavs"][uav]["posed"].get<int>(), 5) << uav;
  EXPECT_NE(r.output.find("northC: no agent has written"), std::string::npos) << r.output;
}

/// It holds the others up only for as long as it is told; the central UAV at that.
TEST_F(FollowedFlight, AUavThatStartsLateOrNeverBlocksNobody) {
  const auto posed = [&](const std::string& outdir, const std::string& uav) {
    return report(outdir)["uavs"][uav]["posed"].get<int>();
  };
  for (const char* uav : {"northB", "northC"}) {
    bring(imagesOf(uav));
    bring(rawlogOf(uav));
  }
  // northA comes when photos of the others have been processed.
  auto followed =
      std::async(std::launch::async, [&] { return follow("out", "-s playback.hold_up_s=0.5"); });
  const auto photos = [&] {
    std::error_code error;
    std::size_t count = 0;
    for (auto it = fs::directory_iterator(folder_ / "out/.cf-run/photos", error);
         !error && it != fs::directory_iterator(); it.increment(error))
      ++count;
    return count;
  };
  while (photos() < 5 &&
         followed.wait_for(std::chrono::milliseconds(50)) != std::future_status::ready) {
  }
  bring(imagesOf("northA"));
  bring(rawlogOf("northA"));
  const CommandResult r = followed.get();
  ASSERT_EQ(r.status, 0) << r.output;
  EXPECT_NE(r.output.find("northA has no photos with fixes yet"), std::string::npos) << r.output;
  for (const std::string& uav : kUavs) EXPECT_EQ(posed("out", uav), 5) << uav;

  // And when it never comes.
  fs::remove(live_ / rawlogOf("northA"));
  const CommandResult without =
      follow("without", "-s playback.hold_up_s=0.5 -s playback.follow_s=2");
  ASSERT_EQ(without.status, 0) << without.output;
  EXPECT_EQ(posed("without", "northB"), 5);
  EXPECT_NE(without.output.find("northA: northA.rawlog has not come"), std::string::npos)
      << without.output;
  EXPECT_NE(report("without")["warnings"].dump().find("northA: it has no photo"),
            std::string::npos);
}

TEST_F(FollowedFlight, APhotoThatDoesNotComeIsSkippedAndSaid) {
  for (const std::string& uav : kUavs) {
    bring(imagesOf(uav));
    bring(rawlogOf(uav));
  }
  fs::remove(live_ / "northB_Images/P12.JPG");
  const CommandResult r = follow("out", "-s playback.follow_s=2");
  ASSERT_EQ(r.status, 0) << r.output;
  EXPECT_NE(r.output.find("northB: photo P12.JPG is skipped: file is missing"), std::string::npos)
      << r.output;
  EXPECT_EQ(report("out")["uavs"]["northB"]["damaged"], 1);
}

TEST_F(FollowedFlight, InterruptedItGoesOnWithoutWaiting) {
  ASSERT_EQ(run(config_, "whole", "").status, 0);
  for (const std::string& uav : kUavs) bring(imagesOf(uav));
  for (const char* uav : {"northA", "northB"}) bring(rawlogOf(uav));
  {
    support::Process following(
        {CF_BIN_DIR "/cf-run", (live_ / "config.ini").string(), "-o", (folder_ / "out").string(),
         "-s", "view.snapshots=false", "-s", "densify.megapixels=0.1", "-s",
         "playback.follow_s=600", "-s", "playback.hold_up_s=0"},
        folder_ / "log");
    while (!fs::exists(folder_ / "out/.cf-run/photos/1_2.jpg") && following.running())
      pauseFor(0.005);
    following.signal(SIGINT);
    EXPECT_EQ(following.wait(), 130) << support::fileText(folder_ / "log");
  }
  bring(rawlogOf("northC"));
  const CommandResult r = run(live_ / "config.ini", "out", "--resume");
  ASSERT_EQ(r.status, 0) << r.output;
  expectSameResults(folder_ / "out", folder_ / "whole");
}

TEST_F(FollowedFlight, WhatCannotBeFollowedIsSaid) {
  EXPECT_EQ(follow("out", "-s playback.rate=1").status, 2);
  const std::string agent =
      " --role agent --uav northB --seam '" + (folder_ / "seam").string() + "'";
  EXPECT_EQ(run(live_ / "config.ini", "", "-s playback.follow_s=1" + agent).status, 2)
      << "the origin must be known to all";
  const CommandResult nothing = follow("out", "-s playback.follow_s=0.5");
  EXPECT_EQ(nothing.status, 1);
  EXPECT_NE(nothing.output.find("no UAV of the configuration has a photo"), std::string::npos)
      << nothing.output;
}

}  // namespace
}  // namespace cf
