// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "arguments.h"

#include <fmt/format.h>

#include <cstdio>

#include "cf/base/error.h"
#include "parse_arguments.h"

namespace cf {
namespace {

/// "H,V" in metres.
Eigen::Vector2d sigmaFrom(const std::string& text) {
  double h = 0, v = 0;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%lf,%lf%c", &h, &v, &rest) != 2 || !(h > 0) || !(v > 0) ||
      !(h < 1e6) || !(v < 1e6))
    throw UsageError("--sigma " + text + ": give two numbers of metres above 0, as in --sigma 2,4");
  return {h, v};
}

}  // namespace

std::optional<ImportOptions> importArguments(int argc, char** argv) {
  ImportOptions options;
  std::string sigma;
  CLI::App app{
      "Turns folders of drone photos into one MRPT rawlog per UAV and a config.ini for cf-run. The "
      "photos are only read; they are linked, or else copied, beside the rawlogs.",
      "cf-import"};
  app.set_version_flag("--version", "cf-import " CF_VERSION);
  app.add_option("--images", options.images,
                 "folder of photos, nested ones included; one UAV each, repeat it for more")
      ->required()
      ->allow_extra_args(false)
      ->type_name("DIR");
  app.add_option("--split", options.split,
                 "make several UAVs of each folder: N parts of equal count by time, or 'strips', "
                 "cut where the track turns")
      ->type_name("N|strips");
  app.add_option("--geo", options.geo,
                 "positions that override EXIF: first line the CRS, then 'name x y z [yaw pitch "
                 "roll] [sigma_h sigma_v]'")
      ->type_name("geo.txt");
  app.add_option("--camera", options.camera,
                 "calibration to use instead of the tagged focal length")
      ->type_name("cam.ini");
  app.add_option("--sigma", sigma,
                 "standard deviation of GNSS positions in metres, horizontal and vertical, where "
                 "the photos carry none (default 2,4)")
      ->type_name("H,V");
  app.add_option(
         "--follow_s", options.follow_s,
         "photos are still arriving: the rawlogs grow with them, for cf-run to follow, until "
         "none has come for so long, or Ctrl-C")
      ->check(CLI::Range(0.1, 86400.0))
      ->type_name("SECONDS");
  app.add_option("-o,--output", options.out_dir, "folder to write")
      ->required()
      ->type_name("OUTDIR");
  app.footer(
      "Example: two UAVs, then their map\n"
      "  cf-import --images DCIM_A --images DCIM_B -o flight\n"
      "  cf-run flight/config.ini -o map\n"
      "Example: one flight, its strips as UAVs\n"
      "  cf-import --images DCIM --split strips -o flight\n"
      "Out comes flight/<uav>.rawlog with <uav>_Images/ beside it, and flight/config.ini.");
  if (!parseArguments(app, argc, argv)) return std::nullopt;
  if (!sigma.empty()) options.sigma_m = sigmaFrom(sigma);
  return options;
}

void printSummary(const ImportSummary& summary) {
  for (const ImportedUav& uav : summary.uavs) {
    const CameraModel& c = uav.camera;
    fmt::print("{}: {} photos", uav.name, uav.photos);
    if (uav.unreadable != 0) fmt::print(" ({} unreadable)", uav.unreadable);
    fmt::print(", {} fixes, {} to {} ({})\n", uav.fixes, isoText(uav.first), isoText(uav.last),
               uav.time_source);
    fmt::print("  camera {}x{}, focal length {:.1f} +- {:.1f} px ({})\n", c.width, c.height, c.fx,
               c.focal_sigma, uav.focal_source);
    if (uav.fixes != 0)
      fmt::print("  GNSS sigma {:.3g}, {:.3g}, {:.3g} m (east, north, up), height datum {}\n",
                 uav.sigma_enu_m.x(), uav.sigma_enu_m.y(), uav.sigma_enu_m.z(), name(uav.datum));
  }
  if (summary.ignored_files != 0)
    fmt::print("{} files beside the photos ignored\n", summary.ignored_files);
  fmt::print("wrote {}\n", summary.config.string());
}

}  // namespace cf
