// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// Flights that are damaged, impossible, or made to do harm, through cf-run: it always ends, with a
// map of what is whole and a word about the rest, or with one clear line (docs/robustness.md).
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "cf/formats/csv.h"
#include "support/synthetic_flight.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

namespace fs = std::filesystem;
using support::CommandResult;
using support::syntheticFlight;

struct Shot {
  ImageFrame frame;  ///< frame.file: relative to the folder of images
  std::vector<unsigned char> jpeg;
  std::optional<GnssFix> fix;
};
using Shots = std::vector<Shot>;

/// What one UAV of the synthetic flight recorded.
Shots shotsOf(std::size_t uav) {
  Shots shots;
  for (const auto& photo : syntheticFlight().uavs[uav].photos) {
    Shot& shot = shots.emplace_back();
    shot.frame.time = photo.time;
    shot.frame.name = photo.name;
    shot.frame.file = photo.name;
    shot.frame.camera = photo.truth.camera;
    shot.frame.attitude = photo.gimbal;
    shot.jpeg = photo.jpeg;
    shot.fix = photo.fix;
  }
  return shots;
}

std::vector<unsigned char> jpegOf(const cv::Mat& picture) {
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", picture, bytes);
  return bytes;
}

class HostileFlight : public ::testing::Test {
 protected:
  fs::path images(const std::string& uav) const { return in_ / (uav + "_Images"); }

  /// Adds a UAV to the flight.
  void write(const std::string& uav, const Shots& shots) const {
    fs::create_directories(in_);
    RawlogWriter writer(in_ / (uav + ".rawlog"));
    for (Shot shot : shots) {
      shot.frame.file = images(uav) / shot.frame.file;
      if (!shot.jpeg.empty()) support::writeBytes(shot.frame.file, shot.jpeg);
      writer.write(shot.frame);
      if (shot.fix) writer.write(*shot.fix);
    }
    writer.finish();
    std::ofstream(in_ / "config.ini", std::ios::app)
        << "[uav." << uav << "]\nrawlog = " << uav << ".rawlog\n";
  }
  CommandResult run() const {
    return support::runCommand(std::string("cd '") + folder_.path().string() +
                               "' && " CF_BIN_DIR "/cf-run '" + (in_ / "config.ini").string() +
                               "' -o '" + out_.string() +
                               "' -w -s view.snapshots=false -s densify.megapixels=0.05"
                               " -s deliver.dsm=false -s deliver.orthophoto=false");
  }
  /// Runs it, expects success, and the report.
  nlohmann::json report() const {
    const CommandResult r = run();
    EXPECT_EQ(r.status, 0) << r.output;
    const std::string text = support::fileText(out_ / "report.json");
    return text.empty() ? nlohmann::json() : nlohmann::json::parse(text);
  }
  std::map<std::string, std::string> column(const std::string& uav, const char* name) const {
    const CsvTable table(out_ / "images" / (uav + ".csv"));
    std::map<std::string, std::string> cells;
    for (const CsvRow& row : table.rows())
      cells[row[table.column("image")]] = row[table.column(name)];
    return cells;
  }
  static void expectWarning(const nlohmann::json& report, const std::string& part) {
    for (const std::string line : report["warnings"])
      if (line.find(part) != std::string::npos) return;
    ADD_FAILURE() << "no warning holds '" << part << "': " << report["warnings"];
  }
  static void expectOneLine(const CommandResult& r, int status, const std::string& part) {
    EXPECT_EQ(r.status, status) << r.output;
    EXPECT_EQ(std::count(r.output.begin(), r.output.end(), '\n'), 1) << r.output;
    EXPECT_NE(r.output.find(part), std::string::npos) << r.output;
  }

  support::TempFolder folder_;
  fs::path in_ = folder_ / "in", out_ = folder_ / "out";
};

TEST_F(HostileFlight, ARawlogThatBreaksOffIsFlownAsFarAsItGoes) {
  write("northA", shotsOf(0));
  write("northB", shotsOf(1));
  const std::string whole = support::fileText(in_ / "northB.rawlog");
  support::writeText(in_ / "northB.rawlog", whole.substr(0, whole.size() * 3 / 4));
  const nlohmann::json r = report();
  expectWarning(r, "northB.rawlog breaks off after");
  const int left = r["uavs"]["northB"]["photos"];
  EXPECT_GE(left, 2);
  EXPECT_LT(left, 5);
  EXPECT_EQ(r["photos"]["posed"], 5 + left);
  support::writeText(in_ / "northB.rawlog", whole.substr(0, 12));
  expectOneLine(run(), 1, "northB.rawlog cannot be read: it is no rawlog, or an empty one");
}

TEST_F(HostileFlight, TimesOutOfOrderRepeatedAndImpossible) {
  Shots a = shotsOf(0), b = shotsOf(1);
  std::reverse(a.begin(), a.end());
  b[1].frame.time = b[2].frame.time;
  b[1].fix.reset();
  b[4].frame.time = b[4].fix->time = 8'000'000'000 * kNsPerSecond;  // 2223
  a[0].frame.time = a[0].fix->time = -5 * kNsPerSecond;
  write("northA", a);
  write("northB", b);
  const nlohmann::json r = report();
  EXPECT_EQ(r["photos"]["total"], 8);
  EXPECT_EQ(r["photos"]["posed"], 8);
  expectWarning(r, "northA.rawlog: 1 images have no time between 1970 and 2200");
  expectWarning(r, "northB.rawlog: 1 images have no time between 1970 and 2200");
}

TEST_F(HostileFlight, FixesOfNoUseAreLeftOutAndTheMapStaysWhereItIs) {
  Shots a = shotsOf(0), b = shotsOf(1);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  a[0].fix->latitude_deg = -33;  // the first of the flight, on another continent
  a[1].fix->latitude_deg = nan;
  a[2].fix->height_m = -std::numeric_limits<double>::infinity();
  b[0].fix->longitude_deg = 999;
  b[3].fix->latitude_deg += 0.1;  // 11 km: for the georeferencer to find
  write("northA", a);
  write("northB", b);
  const nlohmann::json r = report();
  EXPECT_EQ(r["photos"]["posed"], 10);
  expectWarning(r, "northA.rawlog: 2 GNSS records");
  expectWarning(r, "northA.rawlog: 1 GNSS fixes lie over 1000 km from the others");
  const auto world = nlohmann::json::parse(support::fileText(out_ / "world.json"));
  EXPECT_NEAR(world["origin"]["lat"].get<double>(), support::SyntheticFlight::origin().latitude_deg,
              0.01);
}

TEST_F(HostileFlight, PicturesThatAreNoneCostNoMoreThanThemselves) {
  Shots a = shotsOf(0), b = shotsOf(1);
  a[0].jpeg.clear();                                                       // missing
  a[1].jpeg = jpegOf(cv::Mat(640, 480, CV_8UC3, cv::Scalar(90, 90, 90)));  // turned
  std::vector<unsigned char> png;
  cv::imencode(".png", cv::Mat(3, 4, CV_8UC1, cv::Scalar(0)), png);
  png[18] = png[22] = 0xEA, png[19] = png[23] = 0x60;  // says 60000 x 60000
  a[3].jpeg = png;
  b[4].frame.file = "pipe.JPG";
  b[4].frame.name = "P14.JPG";
  b[4].jpeg.clear();
  write("northA", a);
  write("northB", b);
  ASSERT_EQ(mkfifo((images("northB") / "pipe.JPG").c_str(), 0600), 0);
  const nlohmann::json r = report();
  const auto status_a = column("northA", "status"), reason_a = column("northA", "reason");
  EXPECT_EQ(r["uavs"]["northA"]["damaged"], 3);
  EXPECT_EQ(r["uavs"]["northB"]["damaged"], 1);
  EXPECT_EQ(reason_a.at("P00.JPG"), "file is missing");
  EXPECT_EQ(reason_a.at("P01.JPG"),
            "480 x 640 pixels have another shape than the 640 x 480 of the rawlog");
  EXPECT_EQ(reason_a.at("P03.JPG"), "60000 x 60000 pixels are more than any photo has");
  EXPECT_EQ(column("northB", "reason").at("P14.JPG"), "file is missing");
  EXPECT_EQ(r["photos"]["posed"], 6);
  EXPECT_EQ(status_a.at("P02.JPG"), "posed");
  EXPECT_LT(r["peak_rss_mb"].get<double>(), 2000);
}

TEST_F(HostileFlight, APhotoOfAnotherResolutionThanTheRawlogSaysIsUsed) {
  Shots a = shotsOf(0);
  cv::Mat half;
  cv::resize(cv::imdecode(a[2].jpeg, cv::IMREAD_COLOR), half, {320, 240}, 0, 0, cv::INTER_AREA);
  a[2].jpeg = jpegOf(half);
  write("northA", a);
  EXPECT_EQ(report()["photos"]["posed"], 5);
}

TEST_F(HostileFlight, OnePhotoOnly) {
  write("northA", {shotsOf(0)[0]});
  const nlohmann::json r = report();
  EXPECT_EQ(r["photos"]["total"], 1);
  EXPECT_FALSE(column("northA", "status").at("P00.JPG").empty());
  EXPECT_FALSE(column("northA", "status").at("P00.JPG") == "damaged");
}

TEST_F(HostileFlight, NoOverlapAtAll) {
  Shots a = shotsOf(0);
  cv::RNG random(7);
  for (Shot& shot : a) {
    cv::Mat picture(480, 640, CV_8UC3), coarse(60, 80, CV_8UC3);
    random.fill(coarse, cv::RNG::UNIFORM, 0, 256);
    cv::resize(coarse, picture, picture.size(), 0, 0, cv::INTER_CUBIC);
    shot.jpeg = jpegOf(picture);
  }
  write("northA", a);
  const nlohmann::json r = report();
  EXPECT_EQ(r["photos"]["total"], 5);
  for (const auto& [name, status] : column("northA", "status"))
    EXPECT_TRUE(status == "posed" || !column("northA", "reason").at(name).empty()) << name;
}

TEST_F(HostileFlight, AllPhotosBlack) {
  for (std::size_t u : {0u, 1u}) {
    Shots shots = shotsOf(u);
    for (Shot& shot : shots) shot.jpeg = jpegOf(cv::Mat::zeros(480, 640, CV_8UC3));
    write(syntheticFlight().uavs[u].name, shots);
  }
  const nlohmann::json r = report();
  EXPECT_EQ(r["photos"]["total"], 10);
  expectWarning(r, "the photos form 10 parts that no match joins: only GNSS ties them together");
}

TEST_F(HostileFlight, FiftyUavs) {
  for (std::size_t k = 0; k < 50; ++k) {
    Shot shot = shotsOf(k % 3)[k % 5];
    cv::Mat half;
    cv::resize(cv::imdecode(shot.jpeg, cv::IMREAD_COLOR), half, {320, 240}, 0, 0, cv::INTER_AREA);
    shot.jpeg = jpegOf(half);
    shot.frame.camera = shot.frame.camera.scaled(320, 240);
    write("uav" + std::to_string(k), {shot});
  }
  const nlohmann::json r = report();
  EXPECT_EQ(r["uavs"].size(), 50u);
  EXPECT_EQ(r["photos"]["posed"], 50);
  EXPECT_LT(r["peak_rss_mb"].get<double>(), 1000);
}

TEST_F(HostileFlight, NoPhotoAtAll) {
  fs::create_directories(in_);
  {
    RawlogWriter writer(in_ / "a.rawlog");
    writer.write(*shotsOf(0)[0].fix);
    writer.finish();
  }
  support::writeText(in_ / "config.ini", "[uav.a]\nrawlog = a.rawlog\n");
  const CommandResult r = run();
  EXPECT_EQ(r.status, 1);
  EXPECT_NE(r.output.find("no UAV of the configuration has a photo"), std::string::npos)
      << r.output;
  EXPECT_FALSE(fs::exists(out_));
}

TEST_F(HostileFlight, SpacesAndUnicodeInEveryPath) {
  in_ = folder_ / "Flüge am See; 40 m/第一 #1";
  out_ = folder_ / "Karte № 1 (neu)";
  Shots a = shotsOf(0);
  for (Shot& shot : a) {
    shot.frame.name = "Süd " + shot.frame.name;
    shot.frame.file = "Süd ufer/" + shot.frame.name;
  }
  write("nörd lich", a);
  const nlohmann::json r = report();
  EXPECT_EQ(r["uavs"]["nörd lich"]["posed"], 5);
  EXPECT_EQ(column("nörd lich", "status").at("Süd P00.JPG"), "posed");
  EXPECT_TRUE(fs::exists(out_ / "trajectories/nörd lich.tum"));
}

TEST_F(HostileFlight, NamesThatLeaveTheirFolders) {
  Shots a = shotsOf(0);
  a[1].frame.name = "../../../escaped";
  write("northA", a);
  // The writer refuses such a file: put it into the rawlog's bytes.
  const std::string rawlog = (in_ / "northA.rawlog").string();
  ASSERT_EQ(support::runCommand("zcat '" + rawlog + "' > '" + rawlog + ".plain'").status, 0);
  std::string bytes = support::fileText(rawlog + ".plain");
  for (std::size_t at; (at = bytes.find("P02.JPG")) != std::string::npos;)
    bytes.replace(at, 7, "../2.JP");
  support::writeText(rawlog, bytes);
  const nlohmann::json r = report();
  EXPECT_EQ(r["photos"]["total"], 4);
  expectWarning(r, "image '../2.JP' lies outside northA_Images: left out");
  EXPECT_EQ(column("northA", "status").count("escaped"), 1u);
  for (const auto& item : fs::recursive_directory_iterator(folder_.path()))
    if (item.path().filename().string().find("escaped") != std::string::npos) {
      EXPECT_EQ(item.path().string().rfind(out_.string(), 0), 0u) << item.path();
    }
  support::writeText(in_ / "config.ini", "[uav...]\nrawlog = northA.rawlog\n");
  expectOneLine(run(), 2, "names a UAV");
}

}  // namespace
}  // namespace cf
