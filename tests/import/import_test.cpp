// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// cf-import as a user runs it: photo folders in, rawlogs out; bad input gives one clear line and
// the right exit status.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "cf/rawlog/rawlog_reader.h"
#include "support/exif_jpeg.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

using support::CommandResult;
using support::ExifJpeg;

std::string secondText(int second) {
  char text[32];
  std::snprintf(text, sizeof text, "2016:06:23 16:%02d:%02d", second / 60, second % 60);
  return text;
}

class Import : public ::testing::Test {
 protected:
  /// A photo of a flight to the north, one every two seconds.
  ExifJpeg photo(int i) const {
    ExifJpeg jpeg;
    jpeg.dateTime(secondText(2 * i)).word(ExifJpeg::kExif, 0xA405, 20);
    return jpeg.position(46.8 + i * 1e-4, -91.9, 100 + i);
  }
  void flight(const std::string& name, int photos) const {
    for (int i = 0; i < photos; ++i)
      photo(i).write(folder_ / name / ("P" + std::to_string(i) + ".JPG"), 64, 48);
  }
  CommandResult import(const std::string& arguments) const {
    return support::runCommand("cd '" + folder_.path().string() + "' && " CF_BIN_DIR "/cf-import " +
                               arguments);
  }
  UavRecording recording(const std::string& name) const {
    return readRecording(folder_ / "out" / (name + ".rawlog"));
  }
  support::TempFolder folder_;
};

int linesOf(const std::string& text) {
  return static_cast<int>(std::count(text.begin(), text.end(), '\n'));
}

void expectOneLine(const CommandResult& r, int status, const std::string& part) {
  EXPECT_EQ(r.status, status) << r.output;
  EXPECT_EQ(linesOf(r.output), 1) << r.output;
  EXPECT_NE(r.output.find(part), std::string::npos) << r.output;
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST_F(Import, AFolderBecomesARawlogItsImagesAndAConfig) {
  flight("north", 4);
  support::writeText(folder_ / "north/notes.txt", "no photo");
  const CommandResult r = import("--images north --sigma 1.5,3 -o out");
  EXPECT_EQ(r.status, 0) << r.output;
  EXPECT_TRUE(contains(r.output, "north: 4 photos, 4 fixes")) << r.output;
  EXPECT_TRUE(contains(r.output, "1 files beside the photos ignored")) << r.output;
  EXPECT_TRUE(contains(support::fileText(folder_ / "out/config.ini"),
                       "[uav.north]\nrawlog = north.rawlog\n"));
  const UavRecording rec = recording("north");
  ASSERT_EQ(rec.photos.size(), 4u);
  ASSERT_EQ(rec.fixes.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(rec.photos[i].name, "P" + std::to_string(i) + ".JPG");
    EXPECT_EQ(rec.photos[i].time, rec.fixes[i].time);
    EXPECT_EQ(support::fileText(rec.photos[i].file),
              support::fileText(folder_ / "north" / rec.photos[i].name));
    EXPECT_EQ(rec.fixes[i].height_m, 100 + static_cast<int>(i));
    EXPECT_EQ(rec.fixes[i].sigma_enu_m, Eigen::Vector3d(1.5, 1.5, 3));
    EXPECT_EQ(rec.fixes[i].datum, HeightDatum::kUnknown);
  }
  EXPECT_NEAR(rec.photos[0].camera.fx, 20 / std::hypot(36, 24) * 80, 1e-6);
}

TEST_F(Import, AgainIntoTheSameFolderGivesTheSameBytes) {
  flight("north", 3);
  ASSERT_EQ(import("--images north -o out").status, 0);
  const std::string first = support::fileText(folder_ / "out/north.rawlog");
  ASSERT_EQ(import("--images north -o out").status, 0);
  EXPECT_EQ(support::fileText(folder_ / "out/north.rawlog"), first);
}

TEST_F(Import, TheOutputInsideThePhotosIsNotImportedAgain) {
  flight("north", 3);
  ASSERT_EQ(import("--images north -o north/out").status, 0);
  EXPECT_TRUE(contains(import("--images north -o north/out").output, "north: 3 photos"));
}

TEST_F(Import, SplitByNumberAndByStrips) {
  flight("f", 6);
  for (int i = 0; i < 6; ++i) {  // back, 30 m to the east
    ExifJpeg jpeg;
    jpeg.dateTime(secondText(2 * (6 + i))).position(46.8 + (5 - i) * 1e-4, -91.8996, 100);
    jpeg.write(folder_ / "f" / ("Q" + std::to_string(i) + ".JPG"), 64, 48);
  }
  ASSERT_EQ(import("--images f --split 5 -o out").status, 0);
  std::size_t total = 0;
  for (int i = 0; i < 5; ++i) total += recording("f_" + std::to_string(i)).photos.size();
  EXPECT_EQ(total, 12u);
  ASSERT_EQ(import("--images f --split strips -o out").status, 0);
  ASSERT_EQ(recording("f_0").photos.size(), 6u);
  EXPECT_EQ(recording("f_1").photos.front().name, "Q0.JPG");
}

TEST_F(Import, EqualNamesOfFoldersAndPhotosAreToldApart) {
  flight("a/images/100MEDIA", 2);
  photo(2).write(folder_ / "a/images/101MEDIA/P0.JPG", 64, 48);
  flight("b/images", 2);
  ASSERT_EQ(import("--images a/images --images b/images -o out").status, 0);
  const UavRecording a = recording("a_images");
  ASSERT_EQ(a.photos.size(), 3u);
  EXPECT_EQ(a.photos[0].name, "100MEDIA_P0.JPG");
  EXPECT_EQ(a.photos[1].name, "P1.JPG");
  EXPECT_EQ(a.photos[2].name, "101MEDIA_P0.JPG");
  EXPECT_EQ(recording("b_images").photos.size(), 2u);
}

TEST_F(Import, UavsWhoseNamesDifferByCaseAloneAreToldApart) {
  flight("a/North", 2);
  flight("b/north", 3);
  ASSERT_EQ(import("--images a/North --images b/north -o out").status, 0);
  EXPECT_EQ(recording("a_North").photos.size(), 2u);
  EXPECT_EQ(recording("b_north").photos.size(), 3u);
}

TEST_F(Import, GeoOverridesPositionsAndTheirSigma) {
  flight("f", 2);
  support::writeText(folder_ / "geo.txt", "EPSG:4326\nP1.JPG -91.5 46.5 250 0.02 0.05\n");
  const CommandResult r = import("--images f --geo geo.txt -o out");
  EXPECT_TRUE(contains(r.output, "1 photos are not in it")) << r.output;
  const UavRecording rec = recording("f");
  ASSERT_EQ(rec.fixes.size(), 2u);
  EXPECT_EQ(rec.fixes[1].latitude_deg, 46.5);
  EXPECT_EQ(rec.fixes[1].sigma_enu_m, Eigen::Vector3d(0.02, 0.02, 0.05));
  EXPECT_EQ(rec.fixes[0].height_m, 100);
  support::writeText(folder_ / "geo.txt", "EPSG:4326\nnone.JPG -91.5 46.5 250\n");
  expectOneLine(import("--images f --geo geo.txt -o out"), 2, "none.JPG");
}

TEST_F(Import, CameraFileIsScaledToThePhoto) {
  flight("f", 1);
  support::writeText(folder_ / "cam.ini", "[camera]\nwidth=128\nheight=96\nfx=100\nk1=0.1\n");
  ASSERT_EQ(import("--images f --camera cam.ini -o out").status, 0);
  const CameraModel camera = recording("f").photos.at(0).camera;
  EXPECT_EQ(camera.width, 64);
  EXPECT_EQ(camera.fx, 50);
  EXPECT_EQ(camera.k1, 0.1);
}

TEST_F(Import, AFolderWithoutGpsIsARelativeMap) {
  for (int i = 0; i < 3; ++i)
    ExifJpeg()
        .dateTime(secondText(i))
        .word(ExifJpeg::kExif, 0xA405, 20)
        .write(folder_ / "f" / ("P" + std::to_string(i) + ".JPG"), 64, 48);
  const CommandResult r = import("--images f -o out");
  EXPECT_EQ(r.status, 0);
  EXPECT_TRUE(contains(r.output, "no photo in f has a GNSS position: the map will be relative"))
      << r.output;
  EXPECT_TRUE(recording("f").fixes.empty());
  expectOneLine(import("--images f --split strips -o out"), 2, "cannot be cut into strips");
}

TEST_F(Import, DamagedFilesAreRecordedInTheirPlace) {
  flight("f", 4);
  support::writeText(folder_ / "f/P1.JPG", "");
  const std::string bytes = support::fileText(folder_ / "f/P2.JPG");
  support::writeText(folder_ / "f/P2.JPG", bytes.substr(0, bytes.size() - 10));
  const CommandResult r = import("--images f -o out");
  EXPECT_EQ(r.status, 0);
  EXPECT_TRUE(contains(r.output, "f: 1 photos cannot be read")) << r.output;
  const UavRecording rec = recording("f");
  ASSERT_EQ(rec.photos.size(), 4u);
  EXPECT_EQ(rec.photos[1].name, "P1.JPG");
  EXPECT_EQ(rec.photos[1].time - rec.photos[0].time, 2 * kNsPerSecond);
  EXPECT_EQ(rec.photos[1].camera.width, 64) << "the camera of the others";
  EXPECT_EQ(rec.fixes.size(), 3u) << "a truncated photo keeps its tags";
}

TEST_F(Import, TwoSizesInOneFolderKeepTheirOwnCameras) {
  flight("f", 2);
  photo(2).write(folder_ / "f/P2.JPG", 128, 96);
  ASSERT_EQ(import("--images f -o out").status, 0);
  const UavRecording rec = recording("f");
  EXPECT_EQ(rec.photos.at(0).camera.width, 64);
  EXPECT_EQ(rec.photos.at(2).camera.width, 128);
  EXPECT_NEAR(rec.photos.at(2).camera.fx, 2 * rec.photos.at(0).camera.fx, 1e-9);
}

TEST_F(Import, CopiesOfAPhotoAreLeftOut) {
  flight("f", 2);
  std::filesystem::copy_file(folder_ / "f/P0.JPG", folder_ / "f/P0 (1).JPG");
  EXPECT_TRUE(contains(import("--images f -o out").output, "1 photos are copies"));
  EXPECT_EQ(recording("f").photos.size(), 2u);
}

TEST_F(Import, PngWithoutTagsIsImportedAndWhatIsMissingIsSaid) {
  std::filesystem::create_directory(folder_ / "f");
  for (const char* name : {"f/1.png", "f/2.png", "f/10.png"})
    cv::imwrite((folder_ / name).string(), cv::Mat(48, 64, CV_8UC3, cv::Scalar(1, 2, 3)));
  const CommandResult r = import("--images f -o out");
  EXPECT_EQ(r.status, 0);
  EXPECT_TRUE(contains(r.output, "no usable focal length")) << r.output;
  EXPECT_TRUE(contains(r.output, "no photo has a time")) << r.output;
  EXPECT_EQ(recording("f").photos.at(2).name, "10.png");
}

TEST_F(Import, SpacesUnicodeAndLineBreaksInNames) {
  const std::string names[] = {"Süd 1 (a) #2.JPG", "第一 'x'.jpg", "two\nlines.jpg"};
  for (int i = 0; i < 3; ++i) photo(i).write(folder_ / "Flüge; See/日本 1" / names[i], 64, 48);
  const CommandResult r = import("--images 'Flüge; See/日本 1' -o 'out'");
  ASSERT_EQ(r.status, 0) << r.output;
  const std::string config = support::fileText(folder_ / "out/config.ini");
  const std::size_t begin = config.find("[uav.") + 5;
  const UavRecording rec = recording(config.substr(begin, config.find(']') - begin));
  ASSERT_EQ(rec.photos.size(), 3u) << config;
  for (int i = 0; i < 3; ++i) {
    const ImageFrame& frame = rec.photos[static_cast<std::size_t>(i)];
    EXPECT_EQ(frame.file.filename().string(), names[i]);
    EXPECT_TRUE(std::filesystem::is_regular_file(frame.file));
    EXPECT_EQ(frame.name, i < 2 ? names[i] : "two?lines.jpg");
  }
}

TEST_F(Import, TagsThatCannotBeAreAsIfTheyWereNotThere) {
  flight("north", 2);
  ExifJpeg moon, nowhere;
  moon.dateTime("2016:06:23 16:00:04")
      .position(46.8, -91.9, 4e6)
      .rationals(ExifJpeg::kExif, 0x920A, {4e9}, 1);
  moon.xmp(
      "drone-dji:RtkStdLon=\"1e-300\" drone-dji:RtkStdLat=\"1\" drone-dji:RtkStdHgt=\"nan\""
      " drone-dji:GimbalYawDegree=\"inf\" drone-dji:GpsLatitude=\"999\"");
  nowhere.dateTime("2016:13:45 99:99:99").position(91, -91.9, 100);
  moon.write(folder_ / "north/P2.JPG", 64, 48);
  nowhere.write(folder_ / "north/P3.JPG", 64, 48);
  ASSERT_EQ(import("--images north -o out").status, 0);
  const UavRecording rec = recording("north");
  EXPECT_TRUE(rec.warnings.empty()) << rec.warnings[0];
  EXPECT_EQ(rec.photos.size(), 4u);
  ASSERT_EQ(rec.fixes.size(), 3u);
  EXPECT_EQ(rec.fixes[2].latitude_deg, 46.8);
  EXPECT_EQ(rec.fixes[2].sigma_enu_m, Eigen::Vector3d(2, 2, 1000)) << "its height is not known";
  EXPECT_LT(rec.photos[2].camera.fx, 1000);
}

TEST_F(Import, WrongUseIsOneLineAndStatus2) {
  flight("f", 3);
  std::filesystem::create_directory(folder_ / "empty");
  expectOneLine(import("-o out"), 2, "--images");
  expectOneLine(import("--images f"), 2, "--output");
  expectOneLine(import("--images nowhere -o out"), 2, "nowhere");
  expectOneLine(import("--images empty -o out"), 2, "empty holds no photo");
  expectOneLine(import("--images f --split 4 -o out"), 2, "only 3 photos");
  expectOneLine(import("--images f --split some -o out"), 2, "--split some");
  expectOneLine(import("--images f --sigma 2 -o out"), 2, "--sigma 2");
  expectOneLine(import("--images f --sigma 2,-4 -o out"), 2, "--sigma 2,-4");
  expectOneLine(import("--images f --camera none.ini -o out"), 2, "none.ini");
  expectOneLine(import("--images f --colour -o out"), 2, "--colour");
}

TEST_F(Import, AnOutputThatCannotBeWrittenIsStatus1) {
  flight("f", 1);
  support::writeText(folder_ / "file", "in the way");
  expectOneLine(import("--images f -o file/out"), 1, "file/out");
  expectOneLine(import("--images f -o file"), 1, "file");
}

TEST_F(Import, HelpAndVersionAreStatus0) {
  EXPECT_TRUE(contains(import("--help").output, "--split"));
  EXPECT_EQ(import("--help").status, 0);
  EXPECT_TRUE(contains(import("--version").output, "cf-import 0."));
}

TEST_F(Import, BrightonBeachIsThreeStripsOfSix) {
  const std::filesystem::path images =
      std::filesystem::path(CF_REAL_DATA) / "brighton_beach/images";
  if (!std::filesystem::exists(images)) GTEST_SKIP() << images << " is not here";
  ASSERT_EQ(import("--images '" + images.string() + "' --split strips -o out").status, 0);
  for (int i = 0; i < 3; ++i) {
    const UavRecording rec = recording("images_" + std::to_string(i));
    ASSERT_EQ(rec.photos.size(), 6u);
    EXPECT_EQ(rec.photos[0].name, "DJI_00" + std::to_string(18 + 6 * i) + ".JPG");
    EXPECT_EQ(rec.fixes.size(), 6u);
    EXPECT_TRUE(rec.photos[0].attitude);
  }
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out/images_3.rawlog"));
}

}  // namespace
}  // namespace cf
