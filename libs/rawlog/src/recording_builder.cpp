// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "recording_builder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>

#include "cf/base/error.h"
#include "cf/base/text.h"
#include "mrpt_time.h"
#include "note.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

// A camera of somebody else's rawlog is taken as calibrated: its focal length and distortion are
// held within these.
constexpr double kForeignFocalSigma = 0.01;  // of the focal length
constexpr double kForeignDistortionSigma = 0.02;

/// That a sensor can be chosen among those that occur.
void checkLabel(const std::set<std::string>& occurring, const std::string& wanted, const char* key,
                const fs::path& rawlog, bool all_known) {
  if (wanted.empty() ? occurring.size() <= 1 : !all_known || occurring.count(wanted) != 0) return;
  throw UsageError(fmt::format(
      "{}: {} must be one of the sensors in it ({}){}", rawlog.string(), key,
      occurring.empty() ? "there is none" : fmt::format("{}", fmt::join(occurring, ", ")),
      wanted.empty() ? "" : ", not '" + wanted + "'"));
}

/// Takes out what is not later than `until`, in the order in which it was recorded. What has no
/// possible time is not later than anything.
template <class Observation>
std::vector<std::shared_ptr<Observation>> takeUntil(
    TimeNs until, std::vector<std::shared_ptr<Observation>>& from) {
  const auto later = std::stable_partition(from.begin(), from.end(), [&](const auto& o) {
    const std::optional<TimeNs> time = timeOf(o->timestamp);
    return !time || *time <= until;
  });
  std::vector<std::shared_ptr<Observation>> taken(from.begin(), later);
  from.erase(from.begin(), later);
  return taken;
}

CameraModel cameraOf(const mrpt::img::TCamera& c, const Note& note) {
  CameraModel camera;
  camera.width = static_cast<int>(c.ncols);
  camera.height = static_cast<int>(c.nrows);
  camera.fx = c.fx();
  camera.fy = c.fy();
  camera.cx = c.cx();
  camera.cy = c.cy();
  if (c.distortion == mrpt::img::DistortionModel::plumb_bob) {
    camera.k1 = c.k1();
    camera.k2 = c.k2();
    camera.p1 = c.p1();
    camera.p2 = c.p2();
    camera.k3 = c.k3();
  }
  camera.focal_sigma = note.focal_sigma_px.value_or(kForeignFocalSigma * camera.fx);
  camera.k1_sigma = note.k1_sigma.value_or(kForeignDistortionSigma);
  camera.k2_sigma = note.k2_sigma.value_or(kForeignDistortionSigma);
  camera.version = note.camera_version.value_or(0);
  return camera;
}

/// What a photo can have been taken with.
bool isCalibration(const CameraModel& c) {
  constexpr int kLongestSide = 1 << 17;
  constexpr double kMostPixels = 1e7, kMostDistortion = 1e3;
  const auto within = [](std::initializer_list<double> values, double most) {
    return std::all_of(values.begin(), values.end(),
                       [most](double v) { return std::abs(v) <= most; });
  };
  return c.width > 0 && c.height > 0 && c.width <= kLongestSide && c.height <= kLongestSide &&
         c.fx > 0 && c.fy > 0 && within({c.fx, c.fy, c.cx, c.cy}, kMostPixels) &&
         within({c.k1, c.k2, c.p1, c.p2, c.k3}, kMostDistortion);
}

bool staysInside(const fs::path& relative) {
  return relative.is_relative() && std::none_of(relative.begin(), relative.end(),
                                                [](const fs::path& p) { return p == ".."; });
}

/// A base name, whatever the rawlog says: it becomes part of file names.
std::string baseName(const Note& note, const fs::path& file) {
  const fs::path given = fs::path(note.name.value_or("")).filename();
  const bool usable = !given.empty() && given != "." && given != "..";
  return printable((usable ? given : file.filename()).string());
}

/// A place on Earth or above, from a receiver that has one.
bool isPlace(const GnssFix& fix) {
  constexpr double kLowest_m = -1e4, kHighest_m = 1e5;
  return std::abs(fix.latitude_deg) <= 90 && std::abs(fix.longitude_deg) <= 180 &&
         (std::abs(fix.latitude_deg) > 0 || std::abs(fix.longitude_deg) > 0) &&
         fix.height_m >= kLowest_m && fix.height_m <= kHighest_m;
}

Eigen::Vector3d onSphere(const GnssFix& fix) {
  constexpr double kEarthRadius_m = 6.371e6, kRadians = M_PI / 180;
  const double latitude = fix.latitude_deg * kRadians, longitude = fix.longitude_deg * kRadians;
  return kEarthRadius_m * Eigen::Vector3d(std::cos(latitude) * std::cos(longitude),
                                          std::cos(latitude) * std::sin(longitude),
                                          std::sin(latitude));
}

/// In time order, without those from before `last`, which becomes the last of them. Returns how
/// many came too late.
template <class Timed>
std::size_t sortAfter(std::optional<TimeNs>& last, std::vector<Timed>& items) {
  std::stable_sort(items.begin(), items.end(),
                   [](const Timed& a, const Timed& b) { return a.time < b.time; });
  const auto first = std::find_if(items.begin(), items.end(),
                                  [&](const Timed& item) { return !last || item.time >= *last; });
  const auto late = static_cast<std::size_t>(first - items.begin());
  items.erase(items.begin(), first);
  if (!items.empty()) last = items.back().time;
  return late;
}

}  // namespace

/// Notes and attitudes by time and sensor label. What shares both is handed out in file order.
class RecordingBuilder::Companions {
 public:
  Companions(const std::vector<mrpt::obs::CObservationComment::Ptr>& comments,
             const std::vector<mrpt::obs::CObservationIMU::Ptr>& attitudes) {
    for (const auto& c : comments)
      if (std::optional<Note> note = noteFromText(c->text))
        notes_.emplace(Key{c->timestamp, note->sensor}, *note);
    for (const auto& imu : attitudes)
      attitudes_.emplace(Key{imu->timestamp, imu->sensorLabel}, imu);
  }

  /// `image` is empty for a fix.
  Note takeNote(mrpt::Clock::time_point t, const std::string& label, const std::string& image) {
    const auto [begin, end] = notes_.equal_range({t, printable(label)});
    const std::string name = printable(image);
    for (auto it = begin; it != end; ++it)
      if (it->second.image == name) return notes_.extract(it).mapped();
    return {};
  }

  std::optional<GimbalAttitude> takeAttitude(mrpt::Clock::time_point t, const std::string& label) {
    const auto it = attitudes_.find({t, gimbalLabel(label)});
    if (it == attitudes_.end()) return std::nullopt;
    const auto imu = attitudes_.extract(it).mapped();
    using namespace mrpt::obs;
    if (!imu->has(IMU_YAW) || !imu->has(IMU_PITCH) || !imu->has(IMU_ROLL)) return std::nullopt;
    constexpr double kDegrees = 180 / M_PI;
    const GimbalAttitude attitude{imu->get(IMU_YAW) * kDegrees, imu->get(IMU_PITCH) * kDegrees,
                                  imu->get(IMU_ROLL) * kDegrees};
    constexpr double kMost_deg = 1e4;
    for (const double angle : {attitude.yaw_deg, attitude.pitch_deg, attitude.roll_deg})
      if (!(std::abs(angle) <= kMost_deg)) return std::nullopt;
    return attitude;
  }

 private:
  using Key = std::pair<mrpt::Clock::time_point, std::string>;
  std::multimap<Key, Note> notes_;
  std::multimap<Key, mrpt::obs::CObservationIMU::Ptr> attitudes_;
};

void RecordingBuilder::add(const mrpt::serialization::CSerializable::Ptr& record) {
  const auto keep = [](const auto& observation, const std::string& wanted,
                       std::set<std::string>& labels, auto& kept) {
    const std::string label = printable(observation->sensorLabel);
    labels.insert(label);
    if (wanted.empty() || label == wanted) kept.push_back(observation);
  };
  if (auto image = std::dynamic_pointer_cast<mrpt::obs::CObservationImage>(record)) {
    keep(image, labels_.image_label, image_labels_, images_);
  } else if (auto gps = std::dynamic_pointer_cast<mrpt::obs::CObservationGPS>(record)) {
    keep(gps, labels_.gnss_label, gnss_labels_, gps_);
  } else if (auto imu = std::dynamic_pointer_cast<mrpt::obs::CObservationIMU>(record)) {
    attitudes_.push_back(imu);
  } else if (auto text = std::dynamic_pointer_cast<mrpt::obs::CObservationComment>(record)) {
    comments_.push_back(text);
    const std::optional<Note> note = noteFromText(text->text);
    ended_ = ended_ || (note && note->end);
  }
  if (const auto observation = std::dynamic_pointer_cast<mrpt::obs::CObservation>(record))
    if (const auto time = timeOf(observation->timestamp)) newest_ = time;
}

UavRecording RecordingBuilder::take(TimeNs until) {
  const bool all_known = until == std::numeric_limits<TimeNs>::max();
  checkLabel(image_labels_, labels_.image_label, "image_label", rawlog_, all_known);
  checkLabel(gnss_labels_, labels_.gnss_label, "gnss_label", rawlog_, all_known);
  Companions companions(takeUntil(until, comments_), takeUntil(until, attitudes_));
  UavRecording recording;
  recording.photos = photosUntil(until, companions);
  recording.fixes = fixesUntil(until, companions);
  return recording;
}

UavRecording RecordingBuilder::finish() {
  UavRecording recording = take(std::numeric_limits<TimeNs>::max());
  const auto warn = [&](std::size_t count, const char* what) {
    if (count != 0)
      warnings_.push_back(fmt::format("{}: {} {}", rawlog_.filename().string(), count, what));
  };
  warn(counts_.timeless, "images have no time between 1970 and 2200: left out");
  warn(counts_.uncalibrated, "images have no calibration of their own");
  warn(counts_.fisheye, "images have a fisheye calibration: its distortion is taken as zero");
  warn(counts_.useless, "GNSS records without a valid GGA message are left out");
  warn(counts_.far_away, "GNSS fixes lie over 1000 km from the others: left out");
  warn(counts_.late, "images and fixes were recorded after later ones had been taken up: left out");
  recording.warnings = std::move(warnings_);
  return recording;
}

std::vector<ImageFrame> RecordingBuilder::photosUntil(TimeNs until, Companions& companions) {
  const fs::path folder = imagesFolderOf(fs::absolute(rawlog_).lexically_normal());
  std::vector<ImageFrame> photos;
  for (const auto& image : takeUntil(until, images_)) {
    const std::string stored = image->image.getExternalStorageFile();
    if (!staysInside(stored) || !fs::path(stored).has_filename()) {
      warnings_.push_back(fmt::format("{}: image '{}' lies outside {}: left out",
                                      rawlog_.filename().string(), printable(stored),
                                      folder.filename().string()));
      continue;
    }
    const Note note = companions.takeNote(image->timestamp, image->sensorLabel, stored);
    const std::optional<TimeNs> time = timeOf(image->timestamp);
    if (!time) {
      ++counts_.timeless;
      continue;
    }
    ImageFrame photo;
    photo.time = *time;
    photo.file = folder / stored;
    photo.name = baseName(note, photo.file);
    photo.camera = cameraOf(image->cameraParams, note);
    if (!isCalibration(photo.camera)) photo.camera.fx = 0;
    photo.attitude = companions.takeAttitude(image->timestamp, image->sensorLabel);
    photo.height_above_ground_m = note.height_above_ground_m;
    if (image->cameraParams.distortion == mrpt::img::DistortionModel::kannala_brandt)
      ++counts_.fisheye;
    photos.push_back(photo);
  }
  shareCalibrations(photos);
  counts_.late += sortAfter(last_photo_, photos);
  for (ImageFrame& photo : photos) photo.id.index = photos_++;
  return photos;
}

/// Photos without a calibration take that of another, of the same size if there is one; without
/// any in the rawlog they are left as they are, with a focal length of 0.
void RecordingBuilder::shareCalibrations(std::vector<ImageFrame>& photos) {
  for (const ImageFrame& photo : photos) {
    if (!(photo.camera.fx > 0)) continue;
    if (!first_calibration_) first_calibration_ = photo.camera;
    calibrations_.emplace(std::pair(photo.camera.width, photo.camera.height), photo.camera);
  }
  for (ImageFrame& photo : photos) {
    if (photo.camera.fx > 0) continue;
    ++counts_.uncalibrated;
    const auto same = calibrations_.find({photo.camera.width, photo.camera.height});
    if (first_calibration_)
      photo.camera = same != calibrations_.end() ? same->second : *first_calibration_;
  }
}

std::vector<GnssFix> RecordingBuilder::fixesUntil(TimeNs until, Companions& companions) {
  std::vector<GnssFix> fixes;
  for (const auto& gps : takeUntil(until, gps_)) {
    const Note note = companions.takeNote(gps->timestamp, gps->sensorLabel, "");
    const auto* gga = gps->getMsgByClassPtr<mrpt::obs::gnss::Message_NMEA_GGA>();
    const std::optional<TimeNs> time = timeOf(gps->timestamp);
    GnssFix fix;
    if (gga != nullptr) {
      fix.latitude_deg = gga->fields.latitude_degrees;
      fix.longitude_deg = gga->fields.longitude_degrees;
      fix.height_m = gga->fields.altitude_meters;
    }
    if (gga == nullptr || gga->fields.fix_quality == 0 || !time || !isPlace(fix)) {
      ++counts_.useless;
      continue;
    }
    fix.time = *time;
    fix.sigma_enu_m = note.sigma_enu_m.value_or(Eigen::Vector3d(
        kDefaultSigmaHorizontal_m, kDefaultSigmaHorizontal_m, kDefaultSigmaVertical_m));
    fix.datum = note.datum.value_or(HeightDatum::kMsl);  // what GGA's altitude is by definition
    fixes.push_back(fix);
  }
  dropFarAway(fixes);
  counts_.late += sortAfter(last_fix_, fixes);
  return fixes;
}

/// Those that no flight from where the others are can reach.
void RecordingBuilder::dropFarAway(std::vector<GnssFix>& fixes) {
  if (fixes.empty()) return;
  constexpr double kFarthest_m = 1e6;
  Eigen::Vector3d middle;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double>& values = places_m_[axis];
    for (const GnssFix& fix : fixes) values.push_back(onSphere(fix)[axis]);
    const auto half = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), half, values.end());
    middle[axis] = *half;
  }
  const auto far = std::remove_if(fixes.begin(), fixes.end(), [&](const GnssFix& fix) {
    return (onSphere(fix) - middle).norm() > kFarthest_m;
  });
  counts_.far_away += static_cast<std::size_t>(fixes.end() - far);
  fixes.erase(far, fixes.end());
}

}  // namespace cf
