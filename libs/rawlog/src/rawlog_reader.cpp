// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/rawlog/rawlog_reader.h"

#include <fmt/format.h>
#include <mrpt/obs/CObservationComment.h>
#include <mrpt/obs/CObservationGPS.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/serialization/CArchive.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <system_error>

#include "cf/base/error.h"
#include "mrpt_time.h"
#include "note.h"

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
  std::size_t objects = 0;

  void add(const mrpt::serialization::CSerializable::Ptr& object) {
    if (auto frame = std::dynamic_pointer_cast<mrpt::obs::CSensoryFrame>(object)) {
      for (const auto& observation : *frame) add(observation);
    } else if (auto image = std::dynamic_pointer_cast<mrpt::obs::CObservationImage>(object)) {
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

/// A gzip-compressed or plain file, in the form that MRPT's archives read from. MRPT's own stream
/// cannot tell the end of a file that breaks off between two objects from the regular end.
class GzipInput {
 public:
  explicit GzipInput(const fs::path& path)
      : name_(path.string()), file_(gzopen(path.c_str(), "rb")) {}
  ~GzipInput() { gzclose_r(file_); }
  GzipInput(const GzipInput&) = delete;
  GzipInput& operator=(const GzipInput&) = delete;

  bool isOpen() const { return file_ != nullptr; }
  std::size_t Read(void* to, std::size_t bytes) {
    const std::size_t got = gzfread(to, 1, bytes, file_);
    count_ += got;
    return got;
  }
  std::size_t Write(const void*, std::size_t) { return 0; }
  std::string getStreamDescription() const { return name_; }

  std::size_t count() const { return count_; }  ///< bytes read
  bool damaged() const {
    int code = Z_OK;
    gzerror(file_, &code);
    return code != Z_OK;
  }

 private:
  std::string name_;
  gzFile file_;
  std::size_t count_ = 0;
};

Observations readAll(const fs::path& rawlog, Warnings& warnings) {
  std::error_code ignored;
  GzipInput input(rawlog);
  if (!fs::is_regular_file(rawlog, ignored) || !input.isOpen())
    throw RunError(fmt::format("{} cannot be read: there is no such rawlog", rawlog.string()));
  auto archive = mrpt::serialization::archiveFrom(input);
  Observations all;
  std::size_t complete = 0;  // bytes of whole objects
  bool broken = false;
  try {
    for (;; ++all.objects, complete = input.count()) all.add(archive.ReadObject());
  } catch (const mrpt::serialization::CExceptionEOF&) {
    broken = input.damaged() || input.count() != complete;
  } catch (const std::exception&) {
    broken = true;
  }
  if (broken && all.objects != 0)
    warnings.push_back(fmt::format("{} breaks off after {} records: the rest is lost",
                                   rawlog.filename().string(), all.objects));
  if (all.objects == 0)
    throw RunError(
        fmt::format("{} cannot be read: it is no rawlog, or an empty one", rawlog.string()));
  return all;
}

/// Leaves the observations of one sensor: the one named, or the only one there is.
template <class Observation>
void keepSensor(std::vector<std::shared_ptr<Observation>>& observations, const std::string& label,
                const char* key, const fs::path& rawlog) {
  std::set<std::string> labels;
  for (const auto& o : observations) labels.insert(o->sensorLabel);
  if (label.empty() ? labels.size() > 1 : labels.count(label) == 0)
    throw UsageError(
        fmt::format("{}: {} must be one of the sensors in it ({}){}", rawlog.string(), key,
                    labels.empty() ? "there is none" : fmt::format("{}", fmt::join(labels, ", ")),
                    label.empty() ? "" : ", not '" + label + "'"));
  if (label.empty()) return;
  observations.erase(std::remove_if(observations.begin(), observations.end(),
                                    [&](const auto& o) { return o->sensorLabel != label; }),
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
    return GimbalAttitude{imu->get(IMU_YAW) * kDegrees, imu->get(IMU_PITCH) * kDegrees,
                          imu->get(IMU_ROLL) * kDegrees};
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

bool staysInside(const fs::path& relative) {
  return relative.is_relative() && std::none_of(relative.begin(), relative.end(),
                                                [](const fs::path& p) { return p == ".."; });
}

std::vector<ImageFrame> photosOf(const Observations& all, const fs::path& rawlog,
                                 Companions& companions, Warnings& warnings) {
  const fs::path folder = imagesFolderOf(fs::absolute(rawlog).lexically_normal());
  std::vector<ImageFrame> photos;
  std::size_t embedded = 0, uncalibrated = 0, fisheye = 0;
  for (const auto& image : all.images) {
    if (!image->image.isExternallyStored()) {
      ++embedded;
      continue;
    }
    const std::string stored = image->image.getExternalStorageFile();
    if (!staysInside(stored) || stored.empty()) {
      warnings.push_back(fmt::format("{}: image '{}' lies outside {}: left out",
                                     rawlog.filename().string(), stored,
                                     folder.filename().string()));
      continue;
    }
    const Note note = companions.takeNote(image->timestamp, image->sensorLabel, stored);
    ImageFrame photo;
    photo.time = timeOf(image->timestamp);
    photo.file = folder / stored;
    photo.name = note.name.value_or(photo.file.filename().string());
    photo.camera = cameraOf(image->cameraParams, note);
    photo.attitude = companions.takeAttitude(image->timestamp, image->sensorLabel);
    photo.height_above_ground_m = note.height_above_ground_m;
    if (!(photo.camera.fx > 0)) ++uncalibrated;
    if (image->cameraParams.distortion == mrpt::img::DistortionModel::kannala_brandt) ++fisheye;
    photos.push_back(photo);
  }
  const auto warn = [&](std::size_t count, const char* what) {
    if (count != 0)
      warnings.push_back(fmt::format("{}: {} {}", rawlog.filename().string(), count, what));
  };
  warn(embedded, "images are stored inside the rawlog and left out: store them externally");
  warn(uncalibrated, "images have no calibration of their own");
  warn(fisheye, "images have a fisheye calibration: its distortion is taken as zero");
  std::stable_sort(photos.begin(), photos.end(),
                   [](const ImageFrame& a, const ImageFrame& b) { return a.time < b.time; });
  for (std::size_t i = 0; i < photos.size(); ++i)
    photos[i].id.index = static_cast<std::uint32_t>(i);
  return photos;
}

std::vector<GnssFix> fixesOf(const Observations& all, const fs::path& rawlog,
                             Companions& companions, Warnings& warnings) {
  std::vector<GnssFix> fixes;
  std::size_t useless = 0;
  for (const auto& gps : all.fixes) {
    const Note note = companions.takeNote(gps->timestamp, gps->sensorLabel, "");
    const auto* gga = gps->getMsgByClassPtr<mrpt::obs::gnss::Message_NMEA_GGA>();
    GnssFix fix;
    fix.time = timeOf(gps->timestamp);
    if (gga != nullptr) {
      fix.latitude_deg = gga->fields.latitude_degrees;
      fix.longitude_deg = gga->fields.longitude_degrees;
      fix.height_m = gga->fields.altitude_meters;
    }
    if (gga == nullptr || gga->fields.fix_quality == 0 || !(std::abs(fix.latitude_deg) <= 90) ||
        !(std::abs(fix.longitude_deg) <= 180) || !std::isfinite(fix.height_m)) {
      ++useless;
      continue;
    }
    fix.sigma_enu_m = note.sigma_enu_m.value_or(Eigen::Vector3d(
        kDefaultSigmaHorizontal_m, kDefaultSigmaHorizontal_m, kDefaultSigmaVertical_m));
    fix.datum = note.datum.value_or(HeightDatum::kMsl);  // what GGA's altitude is by definition
    fixes.push_back(fix);
  }
  if (useless != 0)
    warnings.push_back(fmt::format("{}: {} GNSS records without a valid GGA message are left out",
                                   rawlog.filename().string(), useless));
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
