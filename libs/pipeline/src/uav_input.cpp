// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "uav_input.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "cf/base/error.h"
#include "cf/config/config.h"
#include "cf/formats/camera_ini.h"

namespace cf {

UavInput::UavInput(const Config& config, const RunOptions& options, std::uint16_t uav)
    : uav_(uav), name_(options.uavs[uav].name), known_until_(std::numeric_limits<TimeNs>::min()) {
  const UavOptions& told = options.uavs[uav];
  rawlog_ = config.resolve(told.rawlog);
  if (!told.sigma.empty()) {
    const auto sigma = parseNumbers(told.sigma, 2, "[uav." + told.name + "] sigma");
    sigma_enu_m_ = {sigma[0], sigma[0], sigma[1]};
  }
  if (!told.camera.empty()) camera_ = readCameraIni(config.resolve(told.camera));
  const RawlogLabels labels{told.image_label, told.gnss_label};
  if (options.playback.follow_s > 0) {
    follower_.emplace(rawlog_, labels);
    return;
  }
  known_until_ = std::numeric_limits<TimeNs>::max();
  UavRecording recording = readRecording(rawlog_, labels);
  warnings_ = std::move(recording.warnings);
  add(std::move(recording));
}

std::vector<GnssFix> UavInput::takeFixes(TimeNs until) {
  const auto later = std::find_if(fixes_.begin(), fixes_.end(),
                                  [&](const GnssFix& fix) { return fix.time > until; });
  std::vector<GnssFix> taken(fixes_.begin(), later);
  fixes_.erase(fixes_.begin(), later);
  return taken;
}

void UavInput::look() {
  if (!follower_) return;
  const std::size_t before = follower_->records();
  add(follower_->poll());
  known_until_ = follower_->knownUntil();
  if (follower_->records() != before) grown_s_ = wallSeconds();
  if (follower_->ended()) close();
}

void UavInput::close() {
  if (!follower_) return;
  UavRecording rest = follower_->finish();
  follower_.reset();
  known_until_ = std::numeric_limits<TimeNs>::max();
  warnings_ = std::move(rest.warnings);
  add(std::move(rest));
}

void UavInput::add(UavRecording recording) {
  for (GnssFix& fix : recording.fixes) {
    if (sigma_enu_m_) fix.sigma_enu_m = *sigma_enu_m_;
    if (!first_fix_) first_fix_ = fix;
    fixes_.push_back(fix);
  }
  for (ImageFrame& photo : recording.photos) {
    photo.id.uav = uav_;
    if (camera_)
      photo.camera = photo.camera.width > 0
                         ? camera_->scaled(photo.camera.width, photo.camera.height)
                         : *camera_;
    if (!(photo.camera.fx > 0) || photo.camera.width <= 0 || photo.camera.height <= 0)
      throw UsageError(fmt::format("{}: photo {} has no calibration: give [uav.{}] camera = FILE",
                                   rawlog_.string(), photo.name, name_));
    photos_.push_back({photo, wallSeconds(), ArrivingFile(photo.file)});
  }
}

}  // namespace cf
