// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "uav_input.h"

#include <fmt/format.h>

#include <algorithm>

#include "cf/base/error.h"
#include "cf/config/config.h"
#include "cf/formats/camera_ini.h"

namespace cf {

UavInput readUav(const Config& config, const RunOptions& options, std::uint16_t uav) {
  const UavOptions& told = options.uavs[uav];
  const std::filesystem::path rawlog = config.resolve(told.rawlog);
  UavInput input{uav, told.name, readRecording(rawlog, {told.image_label, told.gnss_label})};
  if (!told.sigma.empty()) {
    const auto sigma = parseNumbers(told.sigma, 2, "[uav." + told.name + "] sigma");
    for (GnssFix& fix : input.recording.fixes) fix.sigma_enu_m = {sigma[0], sigma[0], sigma[1]};
  }
  std::optional<CameraModel> camera;
  if (!told.camera.empty()) camera = readCameraIni(config.resolve(told.camera));
  for (ImageFrame& photo : input.recording.photos) {
    photo.id.uav = uav;
    if (camera)
      photo.camera = photo.camera.width > 0
                         ? camera->scaled(photo.camera.width, photo.camera.height)
                         : *camera;
    if (!(photo.camera.fx > 0) || photo.camera.width <= 0 || photo.camera.height <= 0)
      throw UsageError(fmt::format("{}: photo {} has no calibration: give [uav.{}] camera = FILE",
                                   rawlog.string(), photo.name, told.name));
  }
  return input;
}

std::optional<GnssFix> firstFix(const UavRecording& recording) {
  const auto first =
      std::min_element(recording.fixes.begin(), recording.fixes.end(),
                       [](const GnssFix& a, const GnssFix& b) { return a.time < b.time; });
  if (first == recording.fixes.end()) return std::nullopt;
  return *first;
}

}  // namespace cf
