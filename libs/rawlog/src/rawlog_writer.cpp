// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/rawlog/rawlog_writer.h"

#include <fmt/format.h>
#include <mrpt/obs/CObservationComment.h>
#include <mrpt/obs/CObservationGPS.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/serialization/CArchive.h>
#include <mrpt/system/datetime.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <system_error>
#include <utility>

#include "cf/base/disk.h"
#include "cf/base/error.h"
#include "mrpt_time.h"
#include "note.h"

namespace cf {
namespace {

constexpr double kRadians = M_PI / 180;

mrpt::img::TCamera mrptCamera(const CameraModel& camera) {
  mrpt::img::TCamera out;
  out.ncols = static_cast<std::uint32_t>(camera.width);
  out.nrows = static_cast<std::uint32_t>(camera.height);
  out.setIntrinsicParamsFromValues(camera.fx, camera.fy, camera.cx, camera.cy);
  out.setDistortionPlumbBob(camera.k1, camera.k2, camera.p1, camera.p2, camera.k3);
  return out;
}

mrpt::obs::CObservationIMU mrptGimbal(const GimbalAttitude& attitude) {
  mrpt::obs::CObservationIMU imu;
  imu.set(mrpt::obs::IMU_YAW, attitude.yaw_deg * kRadians);
  imu.set(mrpt::obs::IMU_PITCH, attitude.pitch_deg * kRadians);
  imu.set(mrpt::obs::IMU_ROLL, attitude.roll_deg * kRadians);
  return imu;
}

mrpt::obs::CObservationGPS mrptGps(const GnssFix& fix) {
  namespace gnss = mrpt::obs::gnss;
  mrpt::system::TTimeParts parts;
  mrpt::system::timestampToParts(mrptTime(fix.time), parts);
  gnss::UTC_time utc;
  utc.hour = parts.hour;
  utc.minute = parts.minute;
  utc.sec = parts.second;

  gnss::Message_NMEA_GGA gga;
  gga.fields.UTCTime = utc;
  gga.fields.latitude_degrees = fix.latitude_deg;
  gga.fields.longitude_degrees = fix.longitude_deg;
  gga.fields.altitude_meters = fix.height_m;
  gga.fields.orthometric_altitude = fix.height_m;
  gga.fields.corrected_orthometric_altitude = fix.height_m;
  gga.fields.fix_quality = 1;

  gnss::Message_NMEA_RMC rmc;
  rmc.fields.UTCTime = utc;
  rmc.fields.validity_char = 'A';
  rmc.fields.positioning_mode = 'A';
  rmc.fields.latitude_degrees = fix.latitude_deg;
  rmc.fields.longitude_degrees = fix.longitude_deg;
  rmc.fields.date_day = parts.day;
  rmc.fields.date_month = parts.month;
  rmc.fields.date_year = static_cast<std::uint8_t>(parts.year % 100);

  mrpt::obs::CObservationGPS gps;
  gps.setMsg(gga);
  gps.setMsg(rmc);
  gps.originalReceivedTimestamp = mrptTime(fix.time);
  gps.has_satellite_timestamp = true;
  return gps;
}

/// A compressed file that MRPT's archives write to.
class GzOutput {
 public:
  /// False if it cannot be written.
  bool open(const std::filesystem::path& path) {
    file_ = gzopen(path.c_str(), "wb6");
    return file_ != nullptr;
  }
  bool isOpen() const { return file_ != nullptr; }
  bool flush() { return gzflush(file_, Z_SYNC_FLUSH) == Z_OK; }
  bool close() { return gzclose_w(std::exchange(file_, nullptr)) == Z_OK; }

  std::size_t Write(const void* from, std::size_t bytes) {
    return static_cast<std::size_t>(
        std::max(0, gzwrite(file_, from, static_cast<unsigned>(bytes))));
  }
  std::size_t Read(void*, std::size_t) { return 0; }
  std::string getStreamDescription() const { return "rawlog"; }

 private:
  gzFile file_ = nullptr;
};

}  // namespace

std::filesystem::path imagesFolderOf(const std::filesystem::path& rawlog) {
  return rawlog.parent_path() / (rawlog.stem().string() + "_Images");
}

struct RawlogWriter::Impl {
  std::filesystem::path path, unfinished, images;
  RawlogLabels labels;
  bool at_once = false, finished = false;
  GzOutput file;
  TimeNs last = 0;

  [[noreturn]] void fail() const {
    throw RunError(fmt::format("{} cannot be written: is the disk full?", unfinished.string()));
  }

  void put(mrpt::obs::CObservation& observation, TimeNs time, const std::string& label) {
    observation.timestamp = mrptTime(time);
    observation.sensorLabel = label;
    last = time;
    auto archive = mrpt::serialization::archiveFrom(file);
    try {
      archive << observation;
    } catch (const std::exception&) {
      fail();
    }
  }
  void put(Note note, TimeNs time, const std::string& label) {
    note.sensor = label;
    mrpt::obs::CObservationComment comment;
    comment.text = noteText(note);
    put(comment, time, label);
  }
};

RawlogWriter::RawlogWriter(const std::filesystem::path& rawlog, const RawlogLabels& labels,
                           Visible visible)
    : impl_(std::make_unique<Impl>()) {
  impl_->path = rawlog;
  impl_->at_once = visible == Visible::kAtOnce;
  impl_->unfinished = rawlog.string() + (impl_->at_once ? "" : ".part");
  impl_->images = imagesFolderOf(rawlog);
  impl_->labels = labels;
  if (!impl_->file.open(impl_->unfinished))
    throw RunError(
        fmt::format("{} cannot be written: is its folder there and writable?", rawlog.string()));
}

RawlogWriter::~RawlogWriter() {
  if (impl_->file.isOpen()) impl_->file.close();
  if (impl_->at_once || impl_->finished) return;
  std::error_code ignored;
  std::filesystem::remove(impl_->unfinished, ignored);
}

void RawlogWriter::write(const ImageFrame& photo) {
  const std::string inside = photo.file.lexically_relative(impl_->images).generic_string();
  if (inside.empty() || inside == "." || inside.rfind("..", 0) == 0)
    throw RunError(fmt::format("{} is not in {}, where the images of {} must be",
                               photo.file.string(), impl_->images.string(),
                               impl_->path.filename().string()));
  mrpt::obs::CObservationImage image;
  image.image.setExternalStorage(inside);
  image.cameraParams = mrptCamera(photo.camera);
  impl_->put(image, photo.time, impl_->labels.image_label);

  Note note;
  note.image = inside;
  if (photo.name != photo.file.filename().string()) note.name = photo.name;
  note.focal_sigma_px = photo.camera.focal_sigma;
  note.k1_sigma = photo.camera.k1_sigma;
  note.k2_sigma = photo.camera.k2_sigma;
  if (photo.camera.version != 0) note.camera_version = photo.camera.version;
  note.height_above_ground_m = photo.height_above_ground_m;
  impl_->put(note, photo.time, impl_->labels.image_label);

  if (photo.attitude) {
    mrpt::obs::CObservationIMU imu = mrptGimbal(*photo.attitude);
    impl_->put(imu, photo.time, gimbalLabel(impl_->labels.image_label));
  }
}

void RawlogWriter::write(const GnssFix& fix) {
  mrpt::obs::CObservationGPS gps = mrptGps(fix);
  impl_->put(gps, fix.time, impl_->labels.gnss_label);
  Note note;
  note.sigma_enu_m = fix.sigma_enu_m;
  note.datum = fix.datum;
  impl_->put(note, fix.time, impl_->labels.gnss_label);
}

void RawlogWriter::flush() {
  if (!impl_->file.flush()) impl_->fail();
}

void RawlogWriter::finish() {
  Note note;
  note.end = true;
  impl_->put(note, impl_->last, {});
  if (!impl_->file.close()) impl_->fail();
  if (impl_->at_once) return;
  if (!syncFile(impl_->unfinished)) impl_->fail();
  std::error_code failed;
  std::filesystem::rename(impl_->unfinished, impl_->path, failed);
  if (failed)
    throw RunError(fmt::format("{} cannot be written: {}", impl_->path.string(), failed.message()));
  impl_->finished = true;
}

}  // namespace cf
