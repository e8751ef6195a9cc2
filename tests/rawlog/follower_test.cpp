// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// A rawlog that is read while it grows gives what it gives when it is complete.
#include "cf/rawlog/rawlog_follower.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <random>

#include "cf/base/error.h"
#include "support/recordings.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

std::string textOf(const UavRecording& r) {
  std::string text;
  for (const ImageFrame& p : r.photos)
    text +=
        fmt::format("photo {} {} {} {} {} {} {} {} {}\n", p.id.index, p.time, p.name,
                    p.file.string(), p.camera.fx, p.camera.focal_sigma, p.camera.version,
                    p.attitude ? p.attitude->yaw_deg : -1, p.height_above_ground_m.value_or(-1));
  for (const GnssFix& f : r.fixes)
    text += fmt::format("fix {} {} {} {} {}\n", f.time, f.latitude_deg, f.height_m,
                        f.sigma_enu_m.x(), name(f.datum));
  for (const std::string& w : r.warnings) text += w + "\n";
  return text;
}

void append(UavRecording& all, const UavRecording& more) {
  all.photos.insert(all.photos.end(), more.photos.begin(), more.photos.end());
  all.fixes.insert(all.fixes.end(), more.fixes.begin(), more.fixes.end());
  all.warnings.insert(all.warnings.end(), more.warnings.begin(), more.warnings.end());
}

class Follower : public ::testing::Test {
 protected:
  static constexpr int kPhotos = 6;

  /// A recording as it lies in the file.
  std::string recording() const {
    RawlogWriter writer(path_);
    for (int i = 0; i < kPhotos; ++i) {
      writer.write(support::fullPhoto(path_, i));
      writer.write(support::fullFix(i));
    }
    writer.finish();
    return support::fileText(path_);
  }
  std::string uncompressed() const {
    recording();
    std::string bytes(1 << 20, '\0');
    gzFile file = gzopen(path_.c_str(), "rb");
    bytes.resize(static_cast<std::size_t>(gzread(file, bytes.data(), 1 << 20)));
    gzclose(file);
    return bytes;
  }
  /// Read while it is written in pieces of random sizes.
  UavRecording followed(const std::string& bytes, unsigned seed) const {
    std::filesystem::remove(path_);
    RawlogFollower follower(path_);
    UavRecording all = follower.poll();
    std::mt19937 random(seed);
    std::ofstream out(path_, std::ios::binary);
    for (std::size_t at = 0; at < bytes.size();) {
      const std::size_t size = std::min<std::size_t>(
          bytes.size() - at, std::uniform_int_distribution<std::size_t>(1, 200)(random));
      out.write(bytes.data() + at, static_cast<std::streamsize>(size));
      out.flush();
      at += size;
      append(all, follower.poll());
      EXPECT_TRUE(all.warnings.empty());
      if (!all.photos.empty()) {  // never a photo without its fix
        EXPECT_GE(all.fixes.size(), all.photos.size());
      }
    }
    append(all, follower.finish());
    return all;
  }
  void expectTheSame(const std::string& bytes) const {
    support::writeText(path_, bytes);
    const std::string whole = textOf(readRecording(path_));
    for (unsigned seed = 0; seed < 30; ++seed)
      ASSERT_EQ(textOf(followed(bytes, seed)), whole) << seed;
  }

  support::TempFolder folder_;
  const std::filesystem::path path_ = folder_ / "uav.rawlog";
};

TEST_F(Follower, PiecesOfAnySizeOfTheCompressedFile) { expectTheSame(recording()); }

TEST_F(Follower, PiecesOfAnySizeOfThePlainFile) { expectTheSame(uncompressed()); }

/// A length that is wrong looks like a record that is not complete, until the next one comes.
TEST_F(Follower, ADamagedRecordCostsItselfAlone) {
  std::string bytes = uncompressed();
  std::size_t note = 0;
  for (int i = 0; i < 4; ++i) note = bytes.find("clusterfusion note", note + 1);
  ASSERT_NE(note, std::string::npos);
  bytes[note - 2] = '\x0f';  // of four bytes, little endian
  support::writeText(path_, bytes);
  EXPECT_NE(textOf(readRecording(path_)).find("1 damaged record"), std::string::npos);
  expectTheSame(bytes);
}

TEST_F(Follower, OneThatBreaksOffIsSaidAtTheEnd) {
  const std::string bytes = uncompressed();
  expectTheSame(bytes.substr(0, bytes.size() * 3 / 5));
  expectTheSame(recording().substr(0, 500));
}

TEST_F(Follower, APhotoIsThereWhenSomethingLaterIs) {
  RawlogWriter writer(path_, {"CAMERA", "GPS"}, RawlogWriter::Visible::kAtOnce);
  RawlogFollower follower(path_);
  const auto write = [&](int i) {
    writer.write(support::fullPhoto(path_, i));
    writer.write(support::fullFix(i));
    writer.flush();
  };
  EXPECT_EQ(follower.records(), 0u);
  write(0);
  EXPECT_TRUE(follower.poll().photos.empty());
  EXPECT_EQ(follower.records(), 5u) << "a flush is on disk";
  EXPECT_EQ(follower.knownUntil(), support::fullPhoto(path_, 0).time - 1);
  write(1);
  UavRecording r = follower.poll();
  ASSERT_EQ(r.photos.size(), 1u);
  ASSERT_EQ(r.fixes.size(), 1u);
  EXPECT_EQ(r.fixes[0].sigma_enu_m, support::fullFix(0).sigma_enu_m) << "with its note";
  EXPECT_TRUE(r.photos[0].attitude);
  write(3);
  write(2);  // before what may have been taken up
  write(4);
  r = follower.poll();
  EXPECT_EQ(r.photos.size(), 3u) << "still in time to be sorted";
  write(2);
  write(5);
  EXPECT_FALSE(follower.ended());
  writer.finish();
  r = follower.poll();
  EXPECT_TRUE(follower.ended());
  EXPECT_EQ(r.photos.size(), 1u);
  r = follower.finish();
  ASSERT_EQ(r.photos.size(), 1u);
  EXPECT_EQ(r.photos[0].id.index, 5u);
  ASSERT_EQ(r.warnings.size(), 1u);
  EXPECT_EQ(r.warnings[0],
            "uav.rawlog: 2 images and fixes were recorded after later ones had been taken up: left "
            "out");
}

/// The last bytes of the compressed file, its checksum, may come after that.
TEST_F(Follower, WhatHasEndedDoesNotBreakOff) {
  const std::string bytes = recording();
  support::writeText(path_, bytes.substr(0, bytes.size() - 4));
  RawlogFollower follower(path_);
  follower.poll();
  EXPECT_TRUE(follower.ended());
  EXPECT_TRUE(follower.finish().warnings.empty());
  EXPECT_TRUE(readRecording(path_).warnings.empty());
}

TEST_F(Follower, OneThatNeverCame) {
  RawlogFollower follower(path_);
  EXPECT_TRUE(follower.poll().photos.empty());
  const UavRecording r = follower.finish();
  ASSERT_EQ(r.warnings.size(), 1u);
  EXPECT_EQ(r.warnings[0], "uav.rawlog has not come");
}

TEST_F(Follower, ALabelMayStillCome) {
  recording();
  RawlogFollower follower(path_, {"OTHER", ""});
  EXPECT_TRUE(follower.poll().photos.empty());
  EXPECT_THROW(follower.finish(), UsageError);
}

}  // namespace
}  // namespace cf
