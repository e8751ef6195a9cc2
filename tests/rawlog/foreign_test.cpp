// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// Rawlogs that others wrote: no notes of ours, other labels, several sensors, sensory frames.
#include <gtest/gtest.h>
#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/obs/CObservationGPS.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/serialization/CArchive.h>

#include "cf/base/error.h"
#include "cf/rawlog/rawlog_reader.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

mrpt::Clock::time_point at(double t) { return mrpt::Clock::fromDouble(t); }

mrpt::obs::CObservationImage::Ptr image(double t, const std::string& file,
                                        const std::string& label = "cam") {
  auto o = mrpt::obs::CObservationImage::Create();
  o->timestamp = at(t);
  o->sensorLabel = label;
  o->image.setExternalStorage(file);
  o->cameraParams.ncols = 640;
  o->cameraParams.nrows = 480;
  o->cameraParams.setIntrinsicParamsFromValues(500, 501, 320, 240);
  o->cameraParams.setDistortionPlumbBob(-0.1, 0.01, 1e-3, 2e-3);
  return o;
}

mrpt::obs::CObservationGPS::Ptr gps(double t, std::uint8_t quality,
                                    const std::string& label = "gps") {
  auto o = mrpt::obs::CObservationGPS::Create();
  mrpt::obs::gnss::Message_NMEA_GGA gga;
  gga.fields.latitude_degrees = 37.5;
  gga.fields.longitude_degrees = -4.25;
  gga.fields.altitude_meters = 600.125;
  gga.fields.fix_quality = quality;
  o->setMsg(gga);
  o->timestamp = at(t);
  o->sensorLabel = label;
  return o;
}

class Foreign : public ::testing::Test {
 protected:
  UavRecording recorded(const std::vector<mrpt::serialization::CSerializable::Ptr>& objects,
                        const RawlogLabels& labels = {}) {
    {
      mrpt::io::CFileGZOutputStream file(path_.string());
      auto archive = mrpt::serialization::archiveFrom(file);
      for (const auto& o : objects) archive << *o;
    }
    return readRecording(path_, labels);
  }
  support::TempFolder folder_;
  const std::filesystem::path path_ = folder_ / "survey.rawlog";
};

TEST_F(Foreign, PlainImagesAndFixesAreTakenWithDefaults) {
  const UavRecording r = recorded({image(10, "a/0001.png"), gps(10.5, 1), image(11, "0002.png")});
  EXPECT_TRUE(r.warnings.empty());
  ASSERT_EQ(r.photos.size(), 2u);
  EXPECT_EQ(r.photos[0].name, "0001.png");
  EXPECT_EQ(r.photos[0].file, folder_.path() / "survey_Images" / "a" / "0001.png");
  EXPECT_EQ(r.photos[0].time, 10 * kNsPerSecond);
  EXPECT_EQ(r.photos[0].camera.width, 640);
  EXPECT_EQ(r.photos[0].camera.fy, 501);
  EXPECT_EQ(r.photos[0].camera.p2, 2e-3);
  EXPECT_EQ(r.photos[0].camera.focal_sigma, 5) << "1 % of a calibrated focal length";
  EXPECT_FALSE(r.photos[0].attitude);
  ASSERT_EQ(r.fixes.size(), 1u);
  EXPECT_EQ(r.fixes[0].latitude_deg, 37.5);
  EXPECT_EQ(r.fixes[0].height_m, 600.125);
  EXPECT_EQ(r.fixes[0].sigma_enu_m, Eigen::Vector3d(2, 2, 4));
  EXPECT_EQ(r.fixes[0].datum, HeightDatum::kMsl) << "as GGA defines its altitude";
}

TEST_F(Foreign, SensoryFramesAreOpened) {
  auto frame = mrpt::obs::CSensoryFrame::Create();
  frame->insert(image(3, "x.jpg"));
  frame->insert(gps(3, 4));
  const UavRecording r = recorded({frame});
  EXPECT_EQ(r.photos.size(), 1u);
  EXPECT_EQ(r.fixes.size(), 1u);
}

TEST_F(Foreign, OneOfSeveralSensorsMustBeNamed) {
  const std::vector<mrpt::serialization::CSerializable::Ptr> both = {
      image(1, "l.jpg", "left"), image(1, "r.jpg", "right"), gps(1, 1, "rover"), gps(1, 1, "base")};
  EXPECT_THROW(recorded(both), UsageError);
  const UavRecording r = recorded(both, {"right", "rover"});
  ASSERT_EQ(r.photos.size(), 1u);
  EXPECT_EQ(r.photos[0].name, "r.jpg");
  EXPECT_EQ(r.fixes.size(), 1u);
}

TEST_F(Foreign, PathsThatLeaveTheFolderAreLeftOut) {
  const UavRecording r = recorded({image(1, "../../etc/secret.png"), image(2, "/etc/secret.png"),
                                   image(3, "in/../../out.png"), image(4, "fine.png")});
  ASSERT_EQ(r.photos.size(), 1u);
  EXPECT_EQ(r.photos[0].name, "fine.png");
  ASSERT_EQ(r.warnings.size(), 3u);
  EXPECT_NE(r.warnings[0].find("../../etc/secret.png"), std::string::npos) << r.warnings[0];
}

TEST_F(Foreign, FixesWithoutReceptionAreLeftOut) {
  auto empty = gps(3, 1);
  empty->clear();
  empty->timestamp = at(3);
  const UavRecording r = recorded({gps(1, 0), gps(2, 1), empty});
  ASSERT_EQ(r.fixes.size(), 1u);
  EXPECT_EQ(r.fixes[0].time, 2 * kNsPerSecond);
  ASSERT_EQ(r.warnings.size(), 1u);
  EXPECT_NE(r.warnings[0].find("2 GNSS records"), std::string::npos) << r.warnings[0];
}

TEST_F(Foreign, ImagesInsideTheRawlogAreLeftOutWithAWarning) {
  auto inside = image(1, "x.png");
  inside->image = mrpt::img::CImage(8, 8, mrpt::img::CH_RGB);
  const UavRecording r = recorded({inside, image(2, "fine.png")});
  EXPECT_EQ(r.photos.size(), 1u);
  ASSERT_EQ(r.warnings.size(), 1u);
  EXPECT_NE(r.warnings[0].find("stored inside"), std::string::npos);
}

TEST_F(Foreign, AnUncalibratedCameraIsSaid) {
  auto o = image(1, "x.png");
  o->cameraParams.setIntrinsicParamsFromValues(0, 0, 0, 0);
  const UavRecording r = recorded({o});
  ASSERT_EQ(r.photos.size(), 1u);
  EXPECT_EQ(r.photos[0].camera.fx, 0);
  ASSERT_EQ(r.warnings.size(), 1u);
  EXPECT_NE(r.warnings[0].find("no calibration"), std::string::npos);
}

}  // namespace
}  // namespace cf
