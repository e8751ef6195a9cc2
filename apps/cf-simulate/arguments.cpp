// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "arguments.h"

#include <fmt/format.h>

#include <algorithm>

#include "parse_arguments.h"

namespace cf {

std::optional<SimulateArguments> simulateArguments(int argc, char** argv) {
  SimulateArguments arguments;
  CLI::App app{
      "Flies simulated UAVs over a simulated world: writes rawlogs, photos and config.ini as "
      "cf-import does, and the exact truth beside them in OUTDIR/truth/.",
      "cf-simulate"};
  app.set_version_flag("--version", "cf-simulate " CF_VERSION);
  app.add_option("config", arguments.config, "what to simulate (docs/simulate.md)")
      ->required()
      ->type_name("SIM.ini");
  app.add_option("-o,--output", arguments.request.outdir, "folder to write")
      ->required()
      ->type_name("OUTDIR");
  app.add_option("-s,--set", arguments.overrides, "override a setting; repeat it for more")
      ->allow_extra_args(false)
      ->type_name("section.key=value");
  app.add_flag("-w,--overwrite", arguments.request.overwrite, "replace an earlier simulation");
  app.footer(
      "Example: three UAVs over a town, their map, and how far it is from the truth\n"
      "  cf-simulate scenes/town_12mp.ini -o town\n"
      "  cf-run town/config.ini -o map -s deliver.depth_maps=1\n"
      "  cf-eval run map town/truth --table\n"
      "Quicker, with smaller photos: -s camera.photo_width=2000 -s camera.photo_height=1500 "
      "-s camera.focal=1350");
  if (!parseArguments(app, argc, argv)) return std::nullopt;
  return arguments;
}

void printSummary(const SimulationSummary& summary, const std::filesystem::path& outdir) {
  std::size_t photos = 0;
  for (const SimulatedUavSummary& uav : summary.uavs) {
    fmt::print("{}: {} photos in {} strip{} from {:.0f} m, a pixel shows {:.1f} cm; {} fixes\n",
               uav.name, uav.photos, uav.strips, uav.strips == 1 ? "" : "s", uav.height_m,
               100 * uav.gsd_m, uav.fixes);
    photos += uav.photos;
  }
  fmt::print("{} photos, {:.2f} s each to render, {:.1f} s in all\nwrote {}\n", photos,
             summary.render_wall_s / static_cast<double>(std::max<std::size_t>(1, photos)),
             summary.wall_s, outdir.string());
}

}  // namespace cf
