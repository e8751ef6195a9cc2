// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/rawlog/rawlog_reader.h"

#include <fmt/format.h>
#include <mrpt/obs/CObservationComment.h>
#include <mrpt/obs/CObservationGPS.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationImage.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <initializer_list>
#include <map>
#include <optional>
#include <set>

#include "cf/base/error.h"
#include "mrpt_time.h"
#include "note.h"
#include "rawlog_records.h"

namespace cf {
namespace {

namespace fs = std::filesystem;
using Warnings = std::vector<std::string>;

// A camera of somebody else's rawlog is taken as calibrated: its focal length and distortion are
// held within these.
constexpr double kForeignFocalSigma = 0.01;  // of the focal length
constexpr double kForeignDistortionSigma = 0.02;

/// The observations of a rawlog that matter to us, in file order.
struct Observations {
  std::vector<mrpt::obs::CObservationImage::Ptr> images;
  std::vector<mrpt::obs::CObservationGPS::Ptr> fixes;
  std::vector<mrpt::obs::CObservationIMU::Ptr> attitudes;
  std::vector<mrpt::obs::CObservationComment::Ptr> comments;

  void add(const mrpt::serialization::CSerializable::Ptr& object) {
    if (auto image = std::dynamic_pointer_cast<mrpt::obs::CObservationImage>(object)) {
      images.push_back(image);
    } else if (auto gps = std::dynamic_pointer_cast<mrpt::obs::CObservationGPS>(object)) {
      fixes.push_back(gps);
    } else if (auto imu = std::dynamic_pointer_cast<mrpt::obs::CObservationIMU>(object)) {
      attitudes.push_back(imu);
    } else if (auto text = std::dynamic_pointer_cast<mrpt::obs::CObservationComment>(object)) {
      comments.push_back(text);
    }
  }
};

Observations readAll(const fs::path& rawlog, Warnings& warnings) {
  RawlogRecords records(rawlog);
  Observations all;
  while (const auto record = records.next()) all.add(record);
  const RawlogRecords::Counts& counts = records.counts();
  const std::string name = rawlog.filename().string();
  if (counts.read + counts.with_pixels + counts.outdated + counts.other_classes.size() == 0)
    throw RunError(
        fmt::format("{} cannot be read: it is no rawlog, or an empty one", rawlog.string()));
  if (counts.breaks_off)
    warnings.push_back(
        fmt::format("{} breaks off after {} records: the rest is lost", name, counts.read));
  if (counts.damaged != 0)
    warnings.push_back(fmt::format("{}: {} damaged records are left out", name, counts.damaged));
  if (counts.with_pixels != 0)
    warnings.push_back(fmt::format(
        "{}: {} images are stored inside the rawlog and left out: store them externally", name,
        counts.with_pixels));
  if (counts.outdated != 0)
    warnings.push_back(fmt::format(
        "{}: {} records of an MRPT older than 1.4 are left out: write it anew with rawlog-edit",
        name, counts.outdated));
  if (!counts.other_classes.empty())
    warnings.push_back(fmt::format("{}: records of other classes are not used: {}", name,
                                   fmt::join(counts.other_classes, ", ")));
  return all;
}

/// Fit for one line of a report.
std::string printable(std::string text) {
  for (char& c : text)
    if (std::iscntrl(static_cast<unsigned char>(c)) != 0) c = '?';
  return text;
}

/// Leaves the observations of one sensor: the one named, or the only one there is.
template <class Observation>
void keepSensor(std::vector<std::shared_ptr<Observation>>& observations, const std::string& label,
                const char* key, const fs::path& rawlog) {
  std::set<std::string> labels;
  for (const auto& o : observations) labels.insert(printable(o->sensorLabel));
  if (label.empty() ? labels.size() > 1 : labels.count(label) == 0)
    throw UsageError(
        fmt::format("{}: {} must be one of the sensors in it ({}){}", rawlog.string(), key,
                    labels.empty() ? "there is none" : fmt::format("{}", fmt::join(labels, ", ")),
                    label.empty() ? "" : ", not '" + label + "'"));
  if (label.empty()) return;
  observations.erase(
      std::remove_if(observations.begin(), observations.end(),
                     [&](const auto& o) { return printable(o->sensorLabel) != label; }),
      observations.end());
}

/// Notes and attitudes by time and sensor label. What shares both is handed out in file order.
class Companions {
 public:
  explicit Companions(const Observations& all) {
    for (const auto& c : all.comments)
      if (std::optional<Note> note = noteFromText(c->text))
        notes_.emplace(Key{c->timestamp, note->sensor}, *note);
    for (const auto& imu : all.attitudes)
      attitudes_.emplace(Key{imu->timestamp, imu->sensorLabel}, imu);
  }

  /// `image` is empty for a fix.
  Note takeNote(mrpt::Clock::time_point t, const std::string& label, const std::string& image) {
    const auto [begin, end] = notes_.equal_range({t, label});
    for (auto it = begin; it != end; ++it)
      if (it->second.image == image) return notes_.extract(it).mapped();
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

/// Photos without a calibration take that of another, of the same size if there is one. Returns how
/// many had none; without any in the rawlog they are left as they are, with a focal length of 0.
std::size_t shareCalibrations(std::vector<ImageFrame>& photos) {
  std::map<std::pair<int, int>, CameraModel> by_size;
  std::optional<CameraModel> first;
  for (const ImageFrame& photo : photos) {
    if (!(photo.camera.fx > 0)) continue;
    if (!first) first = photo.camera;
    by_size.emplace(std::pair(photo.camera.width, photo.camera.height), photo.camera);
  }
  std::size_t count = 0;
  for (ImageFrame& photo : photos) {
    if (photo.camera.fx > 0) continue;
    ++count;
    const auto same = by_size.find({photo.camera.width, photo.camera.height});
    if (first) photo.camera = same != by_size.end() ? same->second : *first;
  }
  return count;
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

std::vector<ImageFrame> photosOf(const Observations& all, const fs::path& rawlog,
                                 Companions& companions, Warnings& warnings) {
  const fs::path folder = imagesFolderOf(fs::absolute(rawlog).lexically_normal());
  std::vector<ImageFrame> photos;
  std::size_t timeless = 0, fisheye = 0;
  for (const auto& image : all.images) {
    const std::string stored = image->image.getExternalStorageFile();
    if (!staysInside(stored) || !fs::path(stored).has_filename()) {
      warnings.push_back(fmt::format("{}: image '{}' lies outside {}: left out",
                                     rawlog.filename().string(), printable(stored),
                                     folder.filename().string()));
      continue;
    }
    const Note note = companions.takeNote(image->timestamp, image->sensorLabel, stored);
    const std::optional<TimeNs> time = timeOf(image->timestamp);
    if (!time) {
      ++timeless;
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
    if (image->cameraParams.distortion == mrpt::img::DistortionModel::kannala_brandt) ++fisheye;
    photos.push_back(photo);
  }
  const std::size_t uncalibrated = shareCalibrations(photos);
  const auto warn = [&](std::size_t count, const char* what) {
    if (count != 0)
      warnings.push_back(fmt::format("{}: {} {}", rawlog.filename().string(), count, what));
  };
  warn(timeless, "images have no time between 1970 and 2200: left out");
  warn(uncalibrated, "images have no calibration of their own");
  warn(fisheye, "images have a fisheye calibration: its distortion is taken as zero");
  std::stable_sort(photos.begin(), photos.end(),
                   [](const ImageFrame& a, const ImageFrame& b) { return a.time < b.time; });
  for (std::size_t i = 0; i < photos.size(); ++i)
    photos[i].id.index = static_cast<std::uint32_t>(i);
  return photos;
}

/// A place on Earth or above, from a receiver that has one.
bool isPlace(const GnssFix& fix) {
  constexpr double kLowest_m = -1e4, kHighest_m = 1e5;
  return std::abs(fix.latitude_deg) <= 90 && std::abs(fix.longitude_deg) <= 180 &&
         (std::abs(fix.latitude_deg) > 0 || std::abs(fix.longitude_deg) > 0) &&
         fix.height_m >= kLowest_m && fix.height_m <= kHighest_m;
}

/// Drops fixes that no flight from where the others are can reach. Returns their number.
std::size_t dropFarAway(std::vector<GnssFix>& fixes) {
  if (fixes.empty()) return 0;
  constexpr double kFarthest_m = 1e6, kEarthRadius_m = 6.371e6, kRadians = M_PI / 180;
  const auto onSphere = [&](const GnssFix& fix) -> Eigen::Vector3d {
    const double latitude = fix.latitude_deg * kRadians, longitude = fix.longitude_deg * kRadians;
    return kEarthRadius_m * Eigen::Vector3d(std::cos(latitude) * std::cos(longitude),
                                            std::cos(latitude) * std::sin(longitude),
                                            std::sin(latitude));
  };
  Eigen::Vector3d middle;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const GnssFix& fix : fixes) values.push_back(onSphere(fix)[axis]);
    const auto half = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), half, values.end());
    middle[axis] = *half;
  }
  const std::size_t before = fixes.size();
  fixes.erase(std::remove_if(fixes.begin(), fixes.end(),
                             [&](const GnssFix& fix) {
                               return (onSphere(fix) - middle).norm() > kFarthest_m;
                             }),
              fixes.end());
  return before - fixes.size();
}

std::vector<GnssFix> fixesOf(const Observations& all, const fs::path& rawlog,
                             Companions& companions, Warnings& warnings) {
  std::vector<GnssFix> fixes;
  std::size_t useless = 0;
  for (const auto& gps : all.fixes) {
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
      ++useless;
      continue;
    }
    fix.time = *time;
    fix.sigma_enu_m = note.sigma_enu_m.value_or(Eigen::Vector3d(
        kDefaultSigmaHorizontal_m, kDefaultSigmaHorizontal_m, kDefaultSigmaVertical_m));
    fix.datum = note.datum.value_or(HeightDatum::kMsl);  // what GGA's altitude is by definition
    fixes.push_back(fix);
  }
  const auto warn = [&](std::size_t count, const char* what) {
    if (count != 0)
      warnings.push_back(fmt::format("{}: {} {}", rawlog.filename().string(), count, what));
  };
  warn(useless, "GNSS records without a valid GGA message are left out");
  warn(dropFarAway(fixes), "GNSS fixes lie over 1000 km from the others: left out");
  std::stable_sort(fixes.begin(), fixes.end(),
                   [](const GnssFix& a, const GnssFix& b) { return a.time < b.time; });
  return fixes;
}

}  // namespace

UavRecording readRecording(const fs::path& rawlog, const RawlogLabels& labels) {
  UavRecording recording;
  Observations all = readAll(rawlog, recording.warnings);
  keepSensor(all.images, labels.image_label, "image_label", rawlog);
  keepSensor(all.fixes, labels.gnss_label, "gnss_label", rawlog);
  Companions companions(all);
  recording.photos = photosOf(all, rawlog, companions, recording.warnings);
  recording.fixes = fixesOf(all, rawlog, companions, recording.warnings);
  return recording;
}

}  // namespace cf
