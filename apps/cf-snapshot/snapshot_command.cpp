// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "snapshot_command.h"

#include <string>

#include "cf/view/render.h"
#include "parse_arguments.h"

namespace cf {

int snapshotCommand(int argc, char** argv) {
  CLI::App app("Renders a picture of a finished run; needs no display.", "cf-snapshot");
  std::string outdir, view = "top", size = "1920x1080", png;
  app.add_option("OUTDIR", outdir, "Output folder of cf-run")->required();
  app.add_option("--view", view, "top | iso | front | uav:<name> | octomap | height")
      ->capture_default_str();
  app.add_option("--size", size, "Width x height [px]")->capture_default_str();
  app.add_option("-o", png, "PNG file to write")->required();
  app.set_version_flag("--version", "cf-snapshot " CF_VERSION);
  app.footer(
      "Example:\n"
      "  cf-snapshot map --view iso --size 1280x720 -o iso.png\n"
      "  cf-snapshot map --view height -o height.png     coloured by height\n"
      "The central UAV's track is white; red lines join photos of two UAVs that were matched.");
  if (!parseArguments(app, argc, argv)) return 0;
  const View wanted = parseView(view);
  const ImageSize pixels = parseImageSize(size);
  SceneLimits limits;
  limits.with_voxels = wanted.kind == View::Kind::kOctomap;
  limits.with_cloud = !limits.with_voxels;
  renderSnapshot(loadScene(outdir, limits), wanted, pixels, png);
  return 0;
}

}  // namespace cf
