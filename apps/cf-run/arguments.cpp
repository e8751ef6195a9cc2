// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "arguments.h"

#include <fmt/format.h>

#include <algorithm>

#include "parse_arguments.h"

namespace cf {
namespace {

/// --role, --uav and --seam belong together.
void takeRole(const std::string& role, const std::string& uav, const std::string& seam,
              const std::string& outdir, RunArguments& arguments) {
  const auto refuse = [](const std::string& what) {
    throw UsageError(what + " (see cf-run --help)");
  };
  if (role.empty() && !seam.empty()) refuse("--seam is for --role agent or central");
  if (role != "agent" && !uav.empty()) refuse("--uav is for --role agent");
  if (role.empty()) return;
  if (seam.empty()) refuse("--role " + role + " needs --seam DIR");
  if (role == "central") {
    arguments.request.seam = seam;
    return;
  }
  if (uav.empty()) refuse("--role agent needs --uav NAME");
  if (!outdir.empty()) refuse("--role agent writes into --seam only: -o is for the central node");
  arguments.agent = {uav, seam, arguments.request.overwrite, arguments.request.resume};
}

}  // namespace

std::optional<RunArguments> runArguments(int argc, char** argv) {
  RunArguments arguments;
  std::string outdir, role, uav, seam;
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
  app.add_option("--role", role,
                 "a part of the run alone: a UAV's agent (odometry, georeference), or the central "
                 "node (alignment, map), which follows the agents' files while they grow")
      ->check(CLI::IsMember({"agent", "central"}));
  app.add_option("--uav", uav, "whose agent it is")->type_name("NAME");
  app.add_option("--seam", seam, "folder through which agents and central node speak: NAME.seam")
      ->type_name("DIR");
  app.footer(
      "Example:\n"
      "  cf-run flight/config.ini -o map\n"
      "  cf-run flight/config.ini -o look -s densify.megapixels=0.3 -s deliver.orthophoto=0   "
      "quick\n"
      "Out comes map/report.html (open this first), orthophoto.tif, dsm.tif, cloud/cloud.ply and "
      ".las,\n"
      "trajectories/, cameras/, octomap.ot, snapshots/. All settings: docs/config.md.");
  if (!parseArguments(app, argc, argv)) return std::nullopt;
  takeRole(role, uav, seam, outdir, arguments);
  arguments.request.version = CF_VERSION;
  arguments.request.outdir =
      outdir.empty() ? std::filesystem::absolute(arguments.config).parent_path() / "results"
                     : std::filesystem::path(outdir);
  return arguments;
}

void printSummary(const AgentSummary& agent) {
  fmt::print("{} photos, {:.2f} MB a photo over the seam\nwrote {}\n", agent.photos,
             1e-6 * static_cast<double>(agent.bytes) /
                 static_cast<double>(std::max<std::size_t>(1, agent.photos)),
             agent.file.string());
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
  for (const std::string& line : doubts(run.self_check)) fmt::print("{}\n", line);
}

}  // namespace cf
