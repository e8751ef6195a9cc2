// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// Folders into which photos keep arriving, while cf-import follows them and cf-run follows it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <nlohmann/json.hpp>
#include <thread>

#include "cf/rawlog/rawlog_follower.h"
#include "support/exif_jpeg.h"
#include "support/process.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

namespace fs = std::filesystem;
using support::ExifJpeg;
using support::Process;

void pauseFor(double s) { std::this_thread::sleep_for(std::chrono::duration<double>(s)); }

std::string textOf(const UavRecording& recording) {
  std::string text;
  for (const ImageFrame& p : recording.photos)
    text += fmt::format("{} {} {} {}\n", p.id.index, p.time, p.name, p.camera.fx);
  for (const GnssFix& f : recording.fixes)
    text += fmt::format("{} {} {}\n", f.time, f.latitude_deg, f.height_m);
  return text;
}

class FollowedFolders : public ::testing::Test {
 protected:
  FollowedFolders() {
    for (const char* uav : {"north", "south"}) fs::create_directories(folder_ / uav);
  }
  /// A photo of a flight to the north, one every two seconds; aside, where nobody looks yet.
  fs::path photo(const std::string& uav, int i) const {
    ExifJpeg jpeg;
    jpeg.dateTime(fmt::format("2016:06:23 16:00:{:02}", 2 * i + (uav == "south" ? 1 : 0)))
        .word(ExifJpeg::kExif, 0xA405, 20)
        .position(46.8 + i * 1e-4, uav == "south" ? -91.9 : -91.901, 100 + i);
    const fs::path file = folder_ / "aside" / uav / fmt::format("P{}.JPG", i);
    fs::create_directories(file.parent_path());
    jpeg.write(file, 64, 48);
    return file;
  }
  /// Copies a part of it.
  void bring(const std::string& uav, int i, double part = 1) const {
    const std::string bytes = support::fileText(photo(uav, i));
    support::writeText(
        folder_ / uav / fmt::format("P{}.JPG", i),
        bytes.substr(0, static_cast<std::size_t>(part * static_cast<double>(bytes.size()))));
  }
  std::vector<std::string> import(const std::string& out) const {
    return {CF_BIN_DIR "/cf-import",      "--images", (folder_ / "north").string(), "--images",
            (folder_ / "south").string(), "-o",       (folder_ / out).string()};
  }
  std::vector<std::string> follow(double seconds) const {
    std::vector<std::string> command = import("out");
    command.insert(command.end(), {"--follow_s", fmt::format("{}", seconds)});
    return command;
  }
  fs::path rawlog(const std::string& uav, const std::string& out = "out") const {
    return folder_ / out / (uav + ".rawlog");
  }
  /// Until the rawlog holds so many records, four a photo.
  void await(
      const std::string& uav, std::size_t records, Process& import,
      const std::function<void()>& meanwhile = [] {}) const {
    RawlogFollower follower(rawlog(uav));
    for (follower.poll(); follower.records() < records; follower.poll()) {
      ASSERT_TRUE(import.running()) << support::fileText(folder_ / "import.log");
      meanwhile();
      pauseFor(0.05);
    }
    EXPECT_EQ(follower.records(), records);
  }

  support::TempFolder folder_;
};

TEST_F(FollowedFolders, PhotosAreRecordedAsTheyArrive) {
  bring("north", 0);
  Process following(follow(3600), folder_ / "import.log");
  await("north", 4, following);
  double part = 0.1;
  const auto copyOn = [&] { bring("north", 1, part = std::min(0.9, part + 0.001)); };
  copyOn();
  bring("north", 2);  // taken after it
  support::writeText(folder_ / "north/notes.txt", "no photo");
  for (int i = 0; i < 3; ++i) bring("south", i);
  await("south", 12, following, copyOn);
  await("north", 4, following);
  bring("north", 1);
  await("north", 12, following);
  following.signal(SIGINT);
  EXPECT_EQ(following.wait(), 0);
  const std::string said = support::fileText(folder_ / "import.log");
  EXPECT_NE(said.find("north: 3 photos, 3 fixes"), std::string::npos) << said;
  EXPECT_NE(said.find("1 files beside the photos ignored"), std::string::npos) << said;

  Process all(import("all"), folder_ / "all.log");
  ASSERT_EQ(all.wait(), 0);
  for (const char* uav : {"north", "south"}) {
    EXPECT_EQ(textOf(readRecording(rawlog(uav))), textOf(readRecording(rawlog(uav, "all"))));
    EXPECT_TRUE(readRecording(rawlog(uav)).warnings.empty());
  }
}

TEST_F(FollowedFolders, TwoCommandsMakeAMapOfThem) {
  Process following(follow(3600), folder_ / "import.log");
  while (!fs::exists(folder_ / "out/config.ini")) pauseFor(0.05);
  Process running({CF_BIN_DIR "/cf-run", (folder_ / "out/config.ini").string(), "-o",
                   (folder_ / "map").string(), "-s", "view.snapshots=false"},
                  folder_ / "run.log");
  for (int i = 0; i < 4; ++i)
    for (const char* uav : {"north", "south"}) bring(uav, i);
  for (const char* uav : {"north", "south"}) await(uav, 16, following);
  EXPECT_TRUE(running.running()) << support::fileText(folder_ / "run.log");
  following.signal(SIGTERM);
  EXPECT_EQ(following.wait(), 0);
  EXPECT_EQ(running.wait(), 0) << support::fileText(folder_ / "run.log");
  const auto report = nlohmann::json::parse(support::fileText(folder_ / "map/report.json"));
  EXPECT_EQ(report["photos"]["total"], 8);
  EXPECT_EQ(report["uavs"]["south"]["damaged"], 0);
}

TEST_F(FollowedFolders, WhatCannotBeTakenIsSaid) {
  bring("north", 1);
  Process following(follow(3600), folder_ / "import.log");
  await("north", 4, following);
  bring("north", 0);
  bring("north", 2, 0.5);
  following.signal(SIGINT);
  EXPECT_EQ(following.wait(), 0);
  const std::string said = support::fileText(folder_ / "import.log");
  for (const char* line :
       {"north/P0.JPG came after photos that were taken later: left out",
        "north/P2.JPG was not complete: left out", "south: no photo has come", "north: 1 photos, "})
    EXPECT_NE(said.find(line), std::string::npos) << line << "\n" << said;
}

TEST_F(FollowedFolders, ItEndsByItselfWhenNothingComesAnyMore) {
  bring("north", 0);
  Process following(follow(0.5), folder_ / "import.log");
  EXPECT_EQ(following.wait(), 0);
  EXPECT_EQ(readRecording(rawlog("north")).photos.size(), 1u);

  std::vector<std::string> split = follow(0.5);
  split.insert(split.end(), {"--split", "2"});
  Process refused(split, folder_ / "refused.log");
  EXPECT_EQ(refused.wait(), 2);
}

}  // namespace
}  // namespace cf
