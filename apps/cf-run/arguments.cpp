// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "arguments.h"

#include <fmt/format.h>

#include <algorithm>

#include "parse_arguments.h"

namespace cf {

std::optional<RunArguments> runArguments(int argc, char** argv) {
  RunArguments arguments;
  std::string outdir;
  CLI::App app{
      "Plays the rawlogs of one or several UAVs and writes one georeferenced dense map: poses, "
      "point cloud, OctoMap, pictures and a report.",
      "cf-run"};
  app.set_version_flag("--version", "cf-run " CF_VERSION);
  app.add_option("config", arguments.config, "experiment, as cf-import writes it")
      ->required()
      ->type_name("CONFIG.ini");
  app.add_option("-o,--output", outdir, "folder to write (default: results beside CONFIG.ini)")
      ->type_name("OUTDIR");
  app.add_option("-s,--set", arguments.overrides, "override a setting; repeat it for more")
      ->allow_extra_args(false)
      ->type_name("section.key=value");
  app.add_flag("-w,--overwrite", arguments.request.overwrite, "replace an earlier result");
  app.add_flag("--resume", arguments.request.resume,
               "go on with an interrupted run, with the same result as if it had not been");
  if (!parseArguments(app, argc, argv)) return std::nullopt;
  arguments.request.version = CF_VERSION;
  arguments.request.outdir =
      outdir.empty() ? std::filesystem::absolute(arguments.config).parent_path() / "results"
                     : std::filesystem::path(outdir);
  return arguments;
}

void printSummary(const RunRecord& run, const std::filesystem::path& outdir) {
  std::size_t photos = 0, posed = 0;
  for (const UavRecord& uav : run.uavs) {
    photos += uav.photos.size();
    posed += uav.final_trajectory.size();
    fmt::print("{}: {} of {} photos posed\n", uav.name, uav.final_trajectory.size(),
               uav.photos.size());
  }
  fmt::print("{} of {} photos posed in {} part{}, {} relative poses between UAVs\n", posed, photos,
             run.components, run.components == 1 ? "" : "s", run.relative_poses.size());
  for (const auto& [stage, seconds] : run.stages)
    fmt::print("  {:<14} {:7.1f} s wall {:7.1f} s CPU\n", stage, seconds.wall_s, seconds.cpu_s);
  fmt::print("{:.1f} s ({:.2f} s per photo), peak memory {:.0f} MB\nwrote {}\n", run.wall_s,
             run.wall_s / static_cast<double>(std::max<std::size_t>(1, photos)), run.peak_rss_mb,
             outdir.string());
}

}  // namespace cf
