// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// Rawlogs that are damaged, or made to do harm: what is whole is read, the rest is left out and
// counted, and memory stays bounded.
#include <gtest/gtest.h>
#include <mrpt/io/CFileOutputStream.h>
#include <mrpt/obs/CObservationGPS.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/serialization/CArchive.h>
#include <sys/stat.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "cf/base/error.h"
#include "cf/base/stopwatch.h"
#include "cf/rawlog/rawlog_reader.h"
#include "support/mrpt_leak.h"
#include "support/recordings.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

using mrpt::serialization::CSerializable;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

class HostileRawlog : public ::testing::Test {
 protected:
  UavRecording read(const std::string& bytes) const {
    support::writeText(path_, bytes);
    return readRecording(path_);
  }
  /// Not compressed, so that bytes are where the records put them.
  static std::string bytesOf(const std::vector<CSerializable::Ptr>& objects) {
    const support::TempFolder folder;
    {
      mrpt::io::CFileOutputStream file((folder / "x").string());
      auto archive = mrpt::serialization::archiveFrom(file);
      for (const auto& o : objects) archive << *o;
    }
    return support::fileText(folder / "x");
  }
  static mrpt::obs::CObservationImage::Ptr image(double t, const std::string& file) {
    auto o = mrpt::obs::CObservationImage::Create();
    o->timestamp = mrpt::Clock::fromDouble(t);
    o->sensorLabel = "cam";
    o->image.setExternalStorage(file);
    o->cameraParams.ncols = 640;
    o->cameraParams.nrows = 480;
    o->cameraParams.setIntrinsicParamsFromValues(500, 501, 320, 240);
    return o;
  }
  static mrpt::obs::CObservationGPS::Ptr gps(double t, double latitude, double longitude,
                                             double height) {
    auto o = mrpt::obs::CObservationGPS::Create();
    mrpt::obs::gnss::Message_NMEA_GGA gga;
    gga.fields.latitude_degrees = latitude;
    gga.fields.longitude_degrees = longitude;
    gga.fields.altitude_meters = height;
    gga.fields.fix_quality = 1;
    o->setMsg(gga);
    o->timestamp = mrpt::Clock::fromDouble(t);
    o->sensorLabel = "gps";
    return o;
  }
  /// Our own recording, compressed.
  std::string recording(int photos) const {
    RawlogWriter writer(path_);
    for (int i = 0; i < photos; ++i) {
      writer.write(support::fullPhoto(path_, i));
      writer.write(support::fullFix(i));
    }
    writer.finish();
    return support::fileText(path_);
  }
  static void expectWarning(const UavRecording& r, const std::string& part) {
    for (const std::string& w : r.warnings)
      if (w.find(part) != std::string::npos) return;
    ADD_FAILURE() << "no warning holds '" << part << "'"
                  << (r.warnings.empty() ? "" : ": " + r.warnings[0]);
  }

  support::TempFolder folder_;
  const std::filesystem::path path_ = folder_ / "uav.rawlog";
};

/// What is left of a recording cut after each byte: never less than of a shorter one.
template <class Read>
void cutEverywhere(const std::string& bytes, const Read& read) {
  std::size_t photos = 0, unsaid = 0;
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    try {
      const UavRecording r = read(bytes.substr(0, size));
      EXPECT_GE(r.photos.size(), photos) << size;
      EXPECT_LE(r.warnings.size(), 1u) << size;
      photos = r.photos.size();
      unsaid += r.warnings.empty() ? 1 : 0;
    } catch (const RunError& e) {
      EXPECT_EQ(photos, 0u) << size << ": " << e.what();
    }
  }
  EXPECT_EQ(photos, 4u);
  // Only after a whole record nothing tells that there was more; a photo has up to 5.
  EXPECT_LE(unsaid, 5 * photos);
}

TEST_F(HostileRawlog, CutAfterAnyByteOfTheCompressedFile) {
  cutEverywhere(recording(4), [&](const std::string& bytes) { return read(bytes); });
}

TEST_F(HostileRawlog, CutAfterAnyByteOfThePlainFile) {
  std::vector<CSerializable::Ptr> objects;
  for (int i = 0; i < 4; ++i) {
    objects.push_back(image(10 + i, "a.jpg"));
    objects.push_back(gps(10 + i, 46.8, -91.9, 200));
  }
  cutEverywhere(bytesOf(objects), [&](const std::string& bytes) { return read(bytes); });
}

TEST_F(HostileRawlog, ALengthOfFourGigabytesCostsNoMemory) {
  const std::string first = bytesOf({image(1, "a.jpg")}), last = bytesOf({image(3, "c.jpg")});
  const std::string whole = bytesOf({image(2, "name_of_a_file.jpg")});
  const double before = peakRssMegabytes();
  for (const char* text : {"name_of_a_file.jpg", "cam\x88"}) {
    std::string bad = whole;
    const std::size_t at = bad.find(text) - 4;
    ASSERT_LT(at, bad.size());
    std::memcpy(&bad[at], "\xF0\xFF\xFF\xFF", 4);
    const UavRecording r = read(first + bad + last);
    EXPECT_EQ(r.photos.size(), 2u);
    expectWarning(r, "1 damaged records are left out");
  }
  EXPECT_LT(peakRssMegabytes() - before, 100);
}

TEST_F(HostileRawlog, OneDamagedRecordCostsNoMoreThanItself) {
  const std::string bytes =
      bytesOf({image(1, "a.jpg"), gps(1, 46.8, -91.9, 200), image(2, "b.jpg"),
               gps(2, 46.8, -91.9, 200), image(3, "c.jpg"), gps(3, 46.8, -91.9, 200)});
  std::size_t least = 3, damaged = 0, labels = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::string bad = bytes;
    bad[i] = static_cast<char>(bad[i] ^ 0xFF);
    UavRecording r;
    try {
      r = read(bad);
    } catch (const UsageError&) {
      ++labels;  // another label is another sensor: the user must choose
      continue;
    }
    least = std::min({least, r.photos.size(), r.fixes.size()});
    damaged += r.warnings.empty() ? 0 : 1;
    EXPECT_GE(r.photos.size() + r.fixes.size(), 5u) << i;
  }
  EXPECT_EQ(least, 2u);
  EXPECT_GT(damaged, 100u);
  EXPECT_EQ(labels, 6 * std::string("cam").size());
}

TEST_F(HostileRawlog, RecordsOfOtherClassesAreNamedAndPassedOver) {
  auto odometry = mrpt::obs::CObservationOdometry::Create();
  std::string unknown = bytesOf({odometry});
  const std::string name = "CObservationOdometry";
  unknown.replace(unknown.find(name), name.size(), "CObservationByNobody");
  const UavRecording r =
      read(bytesOf({image(1, "a.jpg"), odometry}) + unknown + bytesOf({image(2, "b.jpg")}));
  EXPECT_EQ(r.photos.size(), 2u);
  ASSERT_EQ(r.warnings.size(), 1u);
  expectWarning(r, "not used: CObservationByNobody, CObservationOdometry");
}

TEST_F(HostileRawlog, RecordsOfVeryOldVersionsAreLeftOut) {
  std::string old = bytesOf({gps(1, 46.8, -91.9, 200)});
  const std::string name = "CObservationGPS";
  old[old.find(name) + name.size()] = 9;
  const UavRecording r = read(bytesOf({image(1, "a.jpg")}) + old);
  EXPECT_EQ(r.photos.size(), 1u);
  expectWarning(r, "1 records of an MRPT older than 1.4");
}

TEST_F(HostileRawlog, PixelsInsideTheRawlogAreNotDecodedWhateverTheirSize) {
  auto inside = image(2, "x");
  inside->image = mrpt::img::CImage(40, 30, mrpt::img::CH_GRAY);
  inside->image.filledRectangle(0, 0, 39, 29, mrpt::img::TColor::black());
  std::string bytes = bytesOf({inside});
  const std::string size = {40, 0, 0, 0, 30, 0, 0, 0};
  ASSERT_NE(bytes.find(size), std::string::npos);
  bytes.replace(bytes.find(size), 8, {'\x60', '\xEA', 0, 0, '\x60', '\xEA', 0, 0});  // 60000 square
  const double before = peakRssMegabytes();
  const UavRecording r = read(bytesOf({image(1, "a.jpg")}) + bytes + bytesOf({image(3, "b.jpg")}));
  EXPECT_EQ(r.photos.size(), 2u);
  expectWarning(r, "1 images are stored inside the rawlog");
  EXPECT_LT(peakRssMegabytes() - before, 100);
}

TEST_F(HostileRawlog, PhotosWithoutAPossibleTimeAreLeftOut) {
  auto never = image(1, "never.jpg");
  never->timestamp = mrpt::Clock::time_point();
  auto end = image(1, "end.jpg");
  end->timestamp = mrpt::Clock::time_point::max();
  auto lost = gps(1, 46.8, -91.9, 200);
  lost->timestamp = mrpt::Clock::time_point::min();
  const UavRecording r = read(bytesOf({end, image(7, "b.jpg"), never, lost, image(7, "c.jpg"),
                                       image(6, "a.jpg"), image(-3, "before_1970.jpg")}));
  ASSERT_EQ(r.photos.size(), 3u);
  EXPECT_EQ(r.photos[0].name, "a.jpg");
  EXPECT_EQ(r.photos[1].name, "b.jpg") << "of one time, in the order of the file";
  EXPECT_EQ(r.photos[2].name, "c.jpg");
  EXPECT_TRUE(r.fixes.empty());
  expectWarning(r, "3 images have no time between 1970 and 2200: left out");
  expectWarning(r, "1 GNSS records");
}

TEST_F(HostileRawlog, FixesThatAreNoPlaceAreLeftOut) {
  const double inf = std::numeric_limits<double>::infinity();
  const UavRecording r =
      read(bytesOf({gps(1, kNan, -91.9, 200), gps(2, 46.8, inf, 200), gps(3, 46.8, -91.9, -inf),
                    gps(4, 91, -91.9, 200), gps(5, 46.8, -181, 200), gps(6, 0, 0, 0),
                    gps(7, 46.8, -91.9, 1e30), gps(8, 46.8, -91.9, 200)}));
  ASSERT_EQ(r.fixes.size(), 1u);
  EXPECT_EQ(r.fixes[0].time, 8 * kNsPerSecond);
  expectWarning(r, "7 GNSS records");
}

TEST_F(HostileRawlog, FixesOnAnotherContinentAreLeftOut) {
  const UavRecording r =
      read(bytesOf({gps(1, 12, 34, 200), gps(2, 46.8, 179.999, 200), gps(3, 46.8, -179.999, 201),
                    gps(4, 46.8, -179.998, 200), gps(5, -46.8, -179.998, 200)}));
  EXPECT_EQ(r.fixes.size(), 3u) << "the date line is no gap";
  expectWarning(r, "2 GNSS fixes lie over 1000 km from the others");
}

TEST_F(HostileRawlog, ImpossibleCalibrationsGiveWayToThoseOfTheOthers) {
  auto bad = image(2, "b.jpg"), none = image(3, "c.jpg"), wide = image(4, "d.jpg");
  bad->cameraParams.setIntrinsicParamsFromValues(kNan, 500, 320, 240);
  none->cameraParams = {};
  wide->cameraParams.ncols = 600'000;
  const UavRecording r = read(bytesOf({bad, none, wide, image(1, "a.jpg")}));
  ASSERT_EQ(r.photos.size(), 4u);
  for (const ImageFrame& photo : r.photos) {
    EXPECT_EQ(photo.camera.fx, 500) << photo.name;
    EXPECT_EQ(photo.camera.width, 640) << photo.name;
  }
  expectWarning(r, "3 images have no calibration of their own");
}

TEST_F(HostileRawlog, NamesNeverLeaveTheirFolderNorTheirLine) {
  ImageFrame photo = support::fullPhoto(path_, 0), other = support::fullPhoto(path_, 1);
  photo.name = "../../etc/passwd";
  other.name = "..";
  {
    RawlogWriter writer(path_);
    writer.write(photo);
    writer.write(other);
    writer.finish();
  }
  const UavRecording r = readRecording(path_);
  ASSERT_EQ(r.photos.size(), 2u);
  EXPECT_EQ(r.photos[0].name, "passwd");
  EXPECT_EQ(r.photos[1].name, other.file.filename());
  const UavRecording lines = read(bytesOf({image(1, "two\nlines.jpg"), image(2, "../a\nb.jpg")}));
  ASSERT_EQ(lines.photos.size(), 1u);
  EXPECT_EQ(lines.photos[0].name, "two?lines.jpg");
  EXPECT_EQ(lines.photos[0].file.filename(), "two\nlines.jpg");
  ASSERT_EQ(lines.warnings.size(), 1u);
  EXPECT_EQ(lines.warnings[0].find('\n'), std::string::npos);
}

TEST_F(HostileRawlog, NotesOfImpossibleValuesAreNotBelieved) {
  GnssFix fix = support::fullFix(0);
  fix.sigma_enu_m = {1e-30, 1, 1};
  ImageFrame photo = support::fullPhoto(path_, 0);
  photo.camera.focal_sigma = -1;
  photo.height_above_ground_m = 1e300;
  photo.attitude = GimbalAttitude{kNan, 0, 0};
  {
    RawlogWriter writer(path_);
    writer.write(photo);
    writer.write(fix);
    writer.finish();
  }
  const UavRecording r = readRecording(path_);
  ASSERT_EQ(r.photos.size(), 1u);
  EXPECT_GT(r.photos[0].camera.focal_sigma, 0);
  EXPECT_FALSE(r.photos[0].height_above_ground_m);
  EXPECT_FALSE(r.photos[0].attitude);
  ASSERT_EQ(r.fixes.size(), 1u);
  EXPECT_EQ(r.fixes[0].sigma_enu_m, Eigen::Vector3d(2, 2, 4));
}

TEST_F(HostileRawlog, DamageWithoutEndEndsTheReading) {
  const std::string header = "\x9cmrpt::obs::CObservationImage\x04";
  std::string damage;
  for (int i = 0; i < 11'000; ++i) damage += header;
  const UavRecording r = read(bytesOf({image(1, "a.jpg")}) + damage + bytesOf({image(2, "b.jpg")}));
  EXPECT_EQ(r.photos.size(), 1u);
  expectWarning(r, "uav.rawlog breaks off after 1 records: the rest is lost");
}

TEST_F(HostileRawlog, ALongRecordingIsReadPieceByPieceAndWhole) {
  constexpr int kPhotos = 8000;  // 11 MB of records
  recording(kPhotos);
  const double before = peakRssMegabytes();
  const UavRecording r = readRecording(path_);
  EXPECT_TRUE(r.warnings.empty()) << r.warnings[0];
  ASSERT_EQ(r.photos.size(), std::size_t{kPhotos});
  ASSERT_EQ(r.fixes.size(), std::size_t{kPhotos});
  for (int i = 0; i < kPhotos; i += 7) {
    EXPECT_EQ(r.photos[static_cast<std::size_t>(i)].name, support::fullPhoto(path_, i).name);
    EXPECT_EQ(r.fixes[static_cast<std::size_t>(i)].latitude_deg, support::fullFix(i).latitude_deg);
  }
  EXPECT_LT(peakRssMegabytes() - before, 150);
}

TEST_F(HostileRawlog, APipeIsNotWaitedFor) {
  ASSERT_EQ(mkfifo(path_.c_str(), 0600), 0);
  EXPECT_THROW(readRecording(path_), RunError);
}

TEST_F(HostileRawlog, AFileThatOnlyUnpacksToZerosIsNoRawlog) {
  { mrpt::io::CFileOutputStream file(path_.string()); }
  ASSERT_EQ(
      support::runCommand("head -c 50000000 /dev/zero | gzip -c > '" + path_.string() + "'").status,
      0);
  const double before = peakRssMegabytes();
  EXPECT_THROW(readRecording(path_), RunError);
  EXPECT_LT(peakRssMegabytes() - before, 100);
}

}  // namespace
}  // namespace cf
