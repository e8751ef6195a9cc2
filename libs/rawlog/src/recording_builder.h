// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/obs/CObservationComment.h>
#include <mrpt/obs/CObservationGPS.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationImage.h>

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "cf/rawlog/rawlog_reader.h"

namespace cf {

/// Makes photos and fixes of the records of a rawlog: of all at once, or piece by piece while they
/// come.
class RecordingBuilder {
 public:
  RecordingBuilder(std::filesystem::path rawlog, RawlogLabels labels)
      : rawlog_(std::move(rawlog)), labels_(std::move(labels)) {}

  void add(const mrpt::serialization::CSerializable::Ptr& record);
  /// Time of the last record; none: none had any.
  std::optional<TimeNs> newest() const { return newest_; }
  /// The writer has said that nothing follows.
  bool ended() const { return ended_; }

  /// What has come and is not later than `until`, in time order. What is earlier than what was
  /// taken before is left out and counted. Throws UsageError as readRecording() does, but for a
  /// label that does not occur yet.
  UavRecording take(TimeNs until);
  /// The rest, with the warnings about everything.
  UavRecording finish();

 private:
  class Companions;
  std::vector<ImageFrame> photosUntil(TimeNs until, Companions& companions);
  std::vector<GnssFix> fixesUntil(TimeNs until, Companions& companions);
  void shareCalibrations(std::vector<ImageFrame>& photos);
  void dropFarAway(std::vector<GnssFix>& fixes);

  const std::filesystem::path rawlog_;
  const RawlogLabels labels_;
  std::optional<TimeNs> newest_;
  bool ended_ = false;
  // Not taken yet.
  std::vector<mrpt::obs::CObservationImage::Ptr> images_;
  std::vector<mrpt::obs::CObservationGPS::Ptr> gps_;
  std::vector<mrpt::obs::CObservationIMU::Ptr> attitudes_;
  std::vector<mrpt::obs::CObservationComment::Ptr> comments_;
  // Of all so far.
  std::set<std::string> image_labels_, gnss_labels_;
  std::map<std::pair<int, int>, CameraModel> calibrations_;  ///< the first by width and height
  std::optional<CameraModel> first_calibration_;
  std::vector<double> places_m_[3];  ///< of fixes: X, Y, Z on the sphere
  std::optional<TimeNs> last_photo_, last_fix_;
  std::uint32_t photos_ = 0;
  std::vector<std::string> warnings_;
  struct Counts {
    std::size_t timeless = 0, uncalibrated = 0, fisheye = 0, useless = 0, far_away = 0, late = 0;
  };
  Counts counts_;
};

}  // namespace cf
