// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// What we write is what we read, to the last digit; and what becomes of broken files.
#include <gtest/gtest.h>

#include <string>

#include "cf/base/error.h"
#include "cf/rawlog/rawlog_reader.h"
#include "cf/rawlog/rawlog_writer.h"
#include "support/recordings.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

using support::fullFix;
using support::fullPhoto;

class Rawlog : public ::testing::Test {
 protected:
  void writeFull(int photos) {
    RawlogWriter writer(path_);
    for (int i = 0; i < photos; ++i) {
      writer.write(fullPhoto(path_, i));
      writer.write(fullFix(i));
    }
    writer.finish();
  }
  support::TempFolder folder_;
  const std::filesystem::path path_ = folder_ / "uav.rawlog";
};

void expectEqual(const CameraModel& a, const CameraModel& b) {
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_EQ(a.fx, b.fx);
  EXPECT_EQ(a.fy, b.fy);
  EXPECT_EQ(a.cx, b.cx);
  EXPECT_EQ(a.cy, b.cy);
  EXPECT_EQ(a.k1, b.k1);
  EXPECT_EQ(a.k2, b.k2);
  EXPECT_EQ(a.p1, b.p1);
  EXPECT_EQ(a.p2, b.p2);
  EXPECT_EQ(a.k3, b.k3);
  EXPECT_EQ(a.focal_sigma, b.focal_sigma);
  EXPECT_EQ(a.k1_sigma, b.k1_sigma);
  EXPECT_EQ(a.k2_sigma, b.k2_sigma);
  EXPECT_EQ(a.version, b.version);
}

TEST_F(Rawlog, PhotosComeBackExactly) {
  writeFull(3);
  const UavRecording r = readRecording(path_);
  EXPECT_TRUE(r.warnings.empty()) << r.warnings.front();
  ASSERT_EQ(r.photos.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    const ImageFrame expected = fullPhoto(path_, i), &photo = r.photos[static_cast<size_t>(i)];
    EXPECT_EQ(photo.id, (FrameId{0, static_cast<std::uint32_t>(i)}));
    EXPECT_EQ(photo.time, expected.time);
    EXPECT_EQ(photo.name, expected.name);
    EXPECT_EQ(photo.file, expected.file);
    EXPECT_TRUE(photo.image.empty());
    expectEqual(photo.camera, expected.camera);
    ASSERT_TRUE(photo.attitude);
    EXPECT_NEAR(photo.attitude->yaw_deg, expected.attitude->yaw_deg, 1e-12);
    EXPECT_NEAR(photo.attitude->pitch_deg, expected.attitude->pitch_deg, 1e-12);
    EXPECT_NEAR(photo.attitude->roll_deg, expected.attitude->roll_deg, 1e-12);
    EXPECT_EQ(photo.height_above_ground_m, expected.height_above_ground_m);
  }
}

TEST_F(Rawlog, FixesComeBackExactly) {
  writeFull(3);
  const UavRecording r = readRecording(path_);
  ASSERT_EQ(r.fixes.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    const GnssFix expected = fullFix(i), &fix = r.fixes[static_cast<size_t>(i)];
    EXPECT_EQ(fix.time, expected.time);
    EXPECT_EQ(fix.latitude_deg, expected.latitude_deg);
    EXPECT_EQ(fix.longitude_deg, expected.longitude_deg);
    EXPECT_EQ(fix.height_m, expected.height_m);
    EXPECT_EQ(fix.sigma_enu_m, expected.sigma_enu_m);
    EXPECT_EQ(fix.datum, expected.datum);
  }
}

TEST_F(Rawlog, WhatIsNotKnownStaysUnknown) {
  ImageFrame photo = fullPhoto(path_, 0);
  photo.attitude.reset();
  photo.height_above_ground_m.reset();
  photo.camera.focal_sigma = 0;  // held fixed
  {
    RawlogWriter writer(path_);
    writer.write(photo);
    writer.finish();
  }
  const UavRecording r = readRecording(path_);
  ASSERT_EQ(r.photos.size(), 1u);
  EXPECT_FALSE(r.photos[0].attitude);
  EXPECT_FALSE(r.photos[0].height_above_ground_m);
  EXPECT_EQ(r.photos[0].camera.focal_sigma, 0);
  EXPECT_TRUE(r.fixes.empty());
}

TEST_F(Rawlog, PhotosOfOneTimeKeepTheirOwnNotes) {
  {
    RawlogWriter writer(path_);
    for (int i = 0; i < 3; ++i) {
      ImageFrame photo = fullPhoto(path_, i);
      photo.time = 5 * kNsPerSecond;
      writer.write(photo);
    }
    writer.finish();
  }
  const UavRecording r = readRecording(path_);
  ASSERT_EQ(r.photos.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(r.photos[static_cast<size_t>(i)].name, fullPhoto(path_, i).name);
    EXPECT_EQ(r.photos[static_cast<size_t>(i)].height_above_ground_m,
              fullPhoto(path_, i).height_above_ground_m);
  }
}

TEST_F(Rawlog, RecordsAreSortedByTime) {
  {
    RawlogWriter writer(path_);
    for (int i : {2, 0, 1}) writer.write(fullFix(i)), writer.write(fullPhoto(path_, i));
    writer.finish();
  }
  const UavRecording r = readRecording(path_);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(r.photos[i].name, fullPhoto(path_, static_cast<int>(i)).name);
    EXPECT_EQ(r.photos[i].id.index, i);
    EXPECT_EQ(r.fixes[i].time, fullFix(static_cast<int>(i)).time);
  }
}

TEST_F(Rawlog, ANameOtherThanTheFilesComesBack) {
  ImageFrame photo = fullPhoto(path_, 0);
  photo.name = "original.jpg";
  photo.file = imagesFolderOf(path_) / "0001.jpg";
  {
    RawlogWriter writer(path_);
    writer.write(photo);
    writer.finish();
  }
  const UavRecording r = readRecording(path_);
  ASSERT_EQ(r.photos.size(), 1u);
  EXPECT_EQ(r.photos[0].name, "original.jpg");
  EXPECT_EQ(r.photos[0].file, photo.file);
}

TEST_F(Rawlog, ALineBreakInAFilesNameCostsNoneOfItsNote) {
  ImageFrame photo = fullPhoto(path_, 0);
  photo.file = imagesFolderOf(path_) / "two\nlines.jpg";
  {
    RawlogWriter writer(path_);
    writer.write(photo);
    writer.finish();
  }
  const UavRecording r = readRecording(path_);
  ASSERT_EQ(r.photos.size(), 1u);
  EXPECT_EQ(r.photos[0].file, photo.file);
  EXPECT_EQ(r.photos[0].camera.focal_sigma, photo.camera.focal_sigma);
  EXPECT_EQ(r.photos[0].height_above_ground_m, photo.height_above_ground_m);
}

TEST_F(Rawlog, TimesAreRoundedDownToMrptsTicks) {
  GnssFix fix = fullFix(0);
  fix.time = 1466699519'123'456'789;
  {
    RawlogWriter writer(path_);
    writer.write(fix);
    writer.finish();
  }
  EXPECT_EQ(readRecording(path_).fixes.at(0).time, 1466699519'123'456'700);
}

TEST_F(Rawlog, ATruncatedFileGivesWhatWasReadableAndAWarning) {
  writeFull(200);
  const std::string bytes = support::fileText(path_);
  std::size_t last = 0;
  for (const double part : {0.3, 0.6, 0.9}) {
    support::writeText(
        path_, bytes.substr(0, static_cast<std::size_t>(part * static_cast<double>(bytes.size()))));
    const UavRecording r = readRecording(path_);
    EXPECT_GT(r.photos.size(), last);
    EXPECT_LT(r.photos.size(), 200u);
    last = r.photos.size();
    ASSERT_EQ(r.warnings.size(), 1u);
    EXPECT_NE(r.warnings[0].find("uav.rawlog breaks off"), std::string::npos) << r.warnings[0];
  }
}

TEST_F(Rawlog, AnythingElseThanARawlogIsAnErrorThatNamesIt) {
  const auto messageOf = [&] {
    try {
      readRecording(path_);
    } catch (const RunError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_NE(messageOf().find("uav.rawlog"), std::string::npos) << "missing";
  support::writeText(path_, "");
  EXPECT_NE(messageOf().find("uav.rawlog"), std::string::npos) << "empty";
  support::writeText(path_, "[uav.a]\nrawlog = x\n and this is no rawlog at all");
  EXPECT_NE(messageOf().find("uav.rawlog"), std::string::npos) << "text";
  std::filesystem::remove(path_);
  std::filesystem::create_directory(path_);
  EXPECT_NE(messageOf().find("uav.rawlog"), std::string::npos) << "folder";
}

TEST_F(Rawlog, WithoutFinishNoFileIsLeft) {
  { RawlogWriter(path_).write(fullFix(0)); }
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

TEST_F(Rawlog, WhatCannotBeGivenItsNameIsNotLeftEither) {
  std::filesystem::create_directory(path_);
  {
    RawlogWriter writer(path_);
    writer.write(fullFix(0));
    EXPECT_THROW(writer.finish(), RunError);
  }
  EXPECT_TRUE(std::filesystem::is_empty(path_));
  std::filesystem::remove(path_);
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

TEST_F(Rawlog, WritingIntoNoFolderIsARunError) {
  EXPECT_THROW(RawlogWriter(folder_ / "none" / "uav.rawlog"), RunError);
}

TEST_F(Rawlog, APhotoOutsideTheFolderOfImagesIsRefused) {
  RawlogWriter writer(path_);
  ImageFrame photo = fullPhoto(path_, 0);
  photo.file = folder_ / "elsewhere.jpg";
  EXPECT_THROW(writer.write(photo), RunError);
}

TEST_F(Rawlog, LabelsChooseASensorAndWrongOnesAreUsageErrors) {
  {
    RawlogWriter writer(path_, {"FRONT", "ROVER"});
    writer.write(fullPhoto(path_, 0));
    writer.write(fullFix(0));
    writer.finish();
  }
  EXPECT_EQ(readRecording(path_).photos.size(), 1u);
  EXPECT_EQ(readRecording(path_, {"FRONT", "ROVER"}).fixes.at(0).datum, HeightDatum::kEllipsoid);
  try {
    readRecording(path_, {"FRNT", ""});
    FAIL();
  } catch (const UsageError& e) {
    EXPECT_NE(std::string(e.what()).find("FRONT"), std::string::npos) << e.what();
  }
  EXPECT_THROW(readRecording(path_, {"FRONT", "GPS"}), UsageError);
}

}  // namespace
}  // namespace cf
