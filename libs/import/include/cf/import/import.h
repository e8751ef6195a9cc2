// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cf/base/time.h"
#include "cf/types/camera_model.h"
#include "cf/types/gnss_fix.h"

namespace cf {

struct ImportOptions {
  std::vector<std::filesystem::path> images;  ///< one folder per UAV (or per flight to be split)
  std::string split;                          ///< "", "strips", or the number of UAVs
  std::filesystem::path geo;                  ///< geo.txt, or empty
  std::filesystem::path camera;               ///< camera ini, or empty
  std::optional<Eigen::Vector2d> sigma_m;     ///< of fixes without their own: horizontal, vertical
  std::filesystem::path out_dir;
  /// Photos may still arrive: until none has for so long [s]; 0 = all are there.
  double follow_s = 0;
  std::function<bool()> stop;  ///< following: asked now and then; true ends it
};

/// What became one UAV.
struct ImportedUav {
  std::string name;
  std::filesystem::path rawlog;
  std::size_t photos = 0;
  std::size_t unreadable = 0;  ///< of them, files that are no image; recorded all the same
  std::size_t fixes = 0;
  TimeNs first = 0, last = 0;
  std::string time_source;
  CameraModel camera;  ///< the most common one
  std::string focal_source;
  HeightDatum datum = HeightDatum::kUnknown;              ///< of most fixes
  Eigen::Vector3d sigma_enu_m = Eigen::Vector3d::Zero();  ///< median; zero without fixes
};

struct ImportSummary {
  std::vector<ImportedUav> uavs;
  std::size_t ignored_files = 0;  ///< beside the photos
  std::filesystem::path config;
  std::vector<std::string> warnings;
};

/// Turns photo folders into one rawlog per UAV, with linked images, and a config.ini for cf-run,
/// in options.out_dir. The photos are only read. Following, the rawlogs grow as photos arrive, for
/// cf-run to follow: a photo is taken when its file is whole, and left out, with a warning, if one
/// taken later is in the rawlog already. Throws UsageError for options and inputs that make no
/// sense, RunError if the output cannot be written.
ImportSummary importFlights(const ImportOptions& options);

}  // namespace cf
