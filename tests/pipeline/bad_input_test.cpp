// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// What users get wrong, through the programs themselves: one clear line, the contract's exit
// status, and a damaged photo costs no more than itself.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "cf/formats/csv.h"
#include "cf/formats/tum.h"
#include "support/exif_jpeg.h"
#include "support/synthetic_flight.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

namespace fs = std::filesystem;
using support::CommandResult;
using support::ExifJpeg;
using support::syntheticFlight;

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

void expectOneLine(const CommandResult& r, int status, const std::vector<std::string>& parts) {
  EXPECT_EQ(r.status, status) << r.output;
  EXPECT_EQ(std::count(r.output.begin(), r.output.end(), '\n'), 1) << r.output;
  for (const std::string& part : parts) EXPECT_TRUE(contains(r.output, part)) << r.output;
}

class BadInput : public ::testing::Test {
 protected:
  CommandResult command(const std::string& line) const {
    return support::runCommand("cd '" + folder_.path().string() + "' && " CF_BIN_DIR "/" + line);
  }
  CommandResult run(const std::string& arguments) const {
    return command("cf-run " + arguments + " -s view.snapshots=false");
  }
  void ini(const std::string& text) const { support::writeText(folder_ / "c.ini", text); }

  /// The photos of the first UAVs as a camera writes them, a folder each.
  void photoFolders(std::size_t uavs, bool with_gps) const {
    const LocalFrame world(support::SyntheticFlight::origin());
    for (std::size_t u = 0; u < uavs; ++u) {
      const auto& uav = syntheticFlight().uavs[u];
      for (std::size_t i = 0; i < uav.photos.size(); ++i)
        write(uav.name, uav.photos[i].name, u, i, uav.photos[i].jpeg, with_gps);
    }
  }
  void write(const std::string& folder, const std::string& name, std::size_t u, std::size_t i,
             const std::vector<unsigned char>& jpeg, bool with_gps = true) const {
    const auto& photo = syntheticFlight().uavs[u].photos[i];
    ExifJpeg exif;
    exif.dateTime("2016:06:23 16:00:" + std::to_string(10 + 2 * i))
        .word(ExifJpeg::kExif, 0xA405, 28);
    if (with_gps)
      exif.position(photo.fix.latitude_deg, photo.fix.longitude_deg, photo.fix.height_m);
    exif.write(folder_ / folder / name, jpeg);
  }
  /// Rows of images/<uav>.csv by photo: status, reason.
  std::map<std::string, std::pair<std::string, std::string>> statusOf(
      const std::string& uav) const {
    const CsvTable table(folder_ / "out/images" / (uav + ".csv"));
    std::map<std::string, std::pair<std::string, std::string>> rows;
    for (const CsvRow& row : table.rows())
      rows[row[table.column("image")]] = {row[table.column("status")], row[table.column("reason")]};
    return rows;
  }
  nlohmann::json report() const {
    return nlohmann::json::parse(support::fileText(folder_ / "out/report.json"));
  }
  support::TempFolder folder_;
};

TEST_F(BadInput, PhotosWithoutGpsGiveARelativeMap) {
  photoFolders(2, false);
  ASSERT_EQ(command("cf-import --images northA --images northB -o in").status, 0);
  const CommandResult r = run("in/config.ini -o out");
  EXPECT_EQ(r.status, 0) << r.output;
  EXPECT_TRUE(contains(r.output, "the map is relative")) << r.output;
  EXPECT_TRUE(
      nlohmann::json::parse(support::fileText(folder_ / "out/world.json"))["origin"].is_null());
  EXPECT_EQ(report()["photos"]["posed"], 10) << r.output;
  EXPECT_TRUE(fs::exists(folder_ / "out/cloud/cloud.ply"));
}

TEST_F(BadInput, ADamagedPhotoAloneIsSkippedAndSaid) {
  photoFolders(2, true);
  const auto& photos = syntheticFlight().uavs[0].photos;
  auto half = photos[2].jpeg;
  half.resize(half.size() / 2);
  write("northA", photos[2].name, 0, 2, half);
  support::writeText(folder_ / "northB/EMPTY.JPG", "");
  support::writeText(folder_ / "northB/LETTER.JPG", "Dear all, this is no photo.");
  const CommandResult imported = command("cf-import --images northA --images northB -o in");
  ASSERT_EQ(imported.status, 0) << imported.output;
  const CommandResult r = run("in/config.ini -o out");
  EXPECT_EQ(r.status, 0) << r.output;
  const auto a = statusOf("northA"), b = statusOf("northB");
  ASSERT_EQ(a.size(), 5u);
  for (const auto& [name, row] : a) {
    EXPECT_EQ(row.first, name == photos[2].name ? "damaged" : "posed") << name;
    EXPECT_EQ(row.second.empty(), name != photos[2].name) << name << ": " << row.second;
  }
  EXPECT_TRUE(contains(a.at(photos[2].name).second, "breaks off"));
  ASSERT_EQ(b.size(), 7u);
  EXPECT_EQ(b.at("EMPTY.JPG").first, "damaged");
  EXPECT_EQ(b.at("LETTER.JPG").first, "damaged");
  EXPECT_FALSE(b.at("EMPTY.JPG").second.empty());
  EXPECT_EQ(report()["uavs"]["northA"]["damaged"], 1);
  EXPECT_EQ(report()["photos"]["posed"], 9);
}

TEST_F(BadInput, TwoPhotoSizesInOneFolder) {
  photoFolders(2, true);
  for (std::size_t i : {1u, 3u}) {
    cv::Mat small;
    cv::resize(cv::imdecode(syntheticFlight().uavs[0].photos[i].jpeg, cv::IMREAD_COLOR), small,
               {480, 360}, 0, 0, cv::INTER_AREA);
    std::vector<unsigned char> jpeg;
    cv::imencode(".jpg", small, jpeg);
    write("northA", syntheticFlight().uavs[0].photos[i].name, 0, i, jpeg);
  }
  const CommandResult imported = command("cf-import --images northA --images northB -o in");
  ASSERT_EQ(imported.status, 0) << imported.output;
  const CommandResult r = run("in/config.ini -o out");
  EXPECT_EQ(r.status, 0) << r.output;
  EXPECT_EQ(report()["photos"]["posed"], 10) << r.output;
  EXPECT_EQ(report()["components"], 1);
}

TEST_F(BadInput, MisspeltKeysGetTheNearestKnown) {
  ini("[uav.a]\nrawlogg = a.rawlog\n");
  expectOneLine(run("c.ini -o out"), 2, {"c.ini:2", "rawlogg", "did you mean 'rawlog'?"});
  ini("[uav.a]\nrawlog = a.rawlog\n[densify]\nmegapixel = 1\n");
  expectOneLine(run("c.ini -o out"), 2, {"c.ini:4", "did you mean 'megapixels'?"});
  ini("[uav.a]\nrawlog = a.rawlog\n[densify]\nmegapixels = much\n");
  expectOneLine(run("c.ini -o out"), 2, {"c.ini:4", "much is not a number"});
  ini("[uav.a]\nrawlog = a.rawlog\n");
  expectOneLine(run("c.ini -o out -s dense.megapixels=1"), 2, {"[dense]"});
  EXPECT_FALSE(fs::exists(folder_ / "out"));
}

TEST_F(BadInput, AConfigurationThatCannotBePlayed) {
  expectOneLine(run("none.ini -o out"), 2, {"none.ini"});
  ini("");
  expectOneLine(run("c.ini -o out"), 2, {"c.ini", "no [uav.NAME] section"});
  ini("[uav.a]\nsigma = 1,2\n");
  expectOneLine(run("c.ini -o out"), 2, {"[uav.a]", "needs rawlog"});
  ini("[uav.a]\nrawlog = a.rawlog\nsigma = 0,-1\n");
  expectOneLine(run("c.ini -o out"), 2, {"[uav.a]", "sigma"});
  ini("[cluster]\ncenter = b\n[uav.a]\nrawlog = a.rawlog\n");
  expectOneLine(run("c.ini -o out"), 2, {"center = b"});
  ini("[uav.a]\nrawlog = a.rawlog\n");
  expectOneLine(run("c.ini -o out"), 1, {"a.rawlog", "no such rawlog"});
  support::writeText(folder_ / "a.rawlog", "this is no rawlog at all, but text");
  expectOneLine(run("c.ini -o out"), 1, {"a.rawlog", "no rawlog"});
  EXPECT_FALSE(fs::exists(folder_ / "out"));
}

TEST_F(BadInput, AnOutputThatCannotBeWritten) {
  const fs::path config = support::writeSyntheticFlight(folder_ / "in");
  support::writeText(folder_ / "file", "in the way");
  expectOneLine(run("in/config.ini -o file/out"), 1, {"file/out"});
  expectOneLine(run("in/config.ini -o file"), 1, {"file"});
  EXPECT_EQ(support::fileText(folder_ / "file"), "in the way");
}

TEST_F(BadInput, AnEarlierResultStaysUnlessAskedFor) {
  support::writeSyntheticFlight(folder_ / "in");
  support::writeText(folder_ / "out/report.json", "earlier");
  support::writeText(folder_ / "out/images/earlier.csv", "earlier");
  support::writeText(folder_ / "out/depth/northA/earlier.tif", "earlier");
  support::writeText(folder_ / "out/images/DJI_0001.JPG", "somebody's photo");
  expectOneLine(run("in/config.ini -o out"), 2, {"earlier result", "-w"});
  EXPECT_EQ(support::fileText(folder_ / "out/report.json"), "earlier");
  EXPECT_EQ(run("in/config.ini -o out -w -s densify.megapixels=0.05").status, 0);
  EXPECT_EQ(report()["photos"]["total"], 15);
  EXPECT_FALSE(fs::exists(folder_ / "out/images/earlier.csv"));
  EXPECT_FALSE(fs::exists(folder_ / "out/depth/northA/earlier.tif"));
  EXPECT_EQ(support::fileText(folder_ / "out/images/DJI_0001.JPG"), "somebody's photo");
}

TEST_F(BadInput, PhotosWithoutACalibrationNeedACamera) {
  {
    RawlogWriter writer(folder_ / "a.rawlog");
    for (const auto& photo : syntheticFlight().uavs[0].photos) {
      ImageFrame frame;
      frame.time = photo.time;
      frame.name = photo.name;
      frame.file = folder_ / "a_Images" / photo.name;
      support::writeBytes(frame.file, photo.jpeg);
      writer.write(frame);
      writer.write(photo.fix);
    }
    writer.finish();
  }
  ini("[uav.a]\nrawlog = a.rawlog\n");
  expectOneLine(run("c.ini -o out"), 2, {"a.rawlog", "no calibration", "[uav.a] camera"});
  ini("[uav.a]\nrawlog = a.rawlog\ncamera = cam.ini\n");
  expectOneLine(run("c.ini -o out"), 2, {"cam.ini"});
  support::writeText(folder_ / "cam.ini", "[camera]\nwidth = 640\nheight = 480\nfx = 520\n");
  const CommandResult r = run("c.ini -o out");
  EXPECT_EQ(r.status, 0) << r.output;
  EXPECT_EQ(report()["photos"]["posed"], 5) << r.output;
}

TEST_F(BadInput, TheEffectiveConfigurationPlaysFromWhereItLies) {
  support::writeSyntheticFlight(folder_ / "in");
  ASSERT_EQ(run("in/config.ini -o out/first -s densify.megapixels=0.05").status, 0);
  const CommandResult again = run("out/first/config.effective.ini -o out/again");
  ASSERT_EQ(again.status, 0) << again.output;
  for (const char* file : {"trajectories/northB.tum", "config.effective.ini", "cloud/cloud.ply"})
    EXPECT_TRUE(support::fileText(folder_ / "out/first" / file) ==
                support::fileText(folder_ / "out/again" / file))
        << file;
}

}  // namespace
}  // namespace cf
