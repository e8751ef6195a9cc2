// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/simulate/simulation.h"

#include <fmt/format.h>

#include "cf/base/disk.h"
#include "cf/base/error.h"
#include "cf/base/log.h"
#include "cf/base/progress.h"
#include "cf/base/stopwatch.h"
#include "cf/config/config.h"
#include "cf/formats/atomic_file.h"
#include "cf/rawlog/rawlog_writer.h"
#include "cluster_flight.h"
#include "random_stream.h"
#include "recording.h"
#include "reference_surface.h"
#include "truth_files.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

/// Removes what is where the simulation's files will be, or throws where that is not wanted: it may
/// be an earlier simulation, or a flight that somebody recorded.
void clear(const SimulationRequest& request, const SimulationSetup& setup) {
  std::vector<fs::path> in_the_way = {request.outdir / "truth"};
  for (const SimulatedUavOptions& uav : setup.uavs) {
    const fs::path rawlog = request.outdir / (uav.name + ".rawlog");
    in_the_way.insert(in_the_way.end(), {rawlog, imagesFolderOf(rawlog)});
  }
  for (const fs::path& path : in_the_way) {
    std::error_code error;
    if (!request.overwrite && fs::exists(path, error))
      throw UsageError(path.string() + " is there already; give -w to overwrite it");
    fs::remove_all(path, error);
    if (error)
      throw RunError(fmt::format("{}: cannot be removed: {}", path.string(), error.message()));
  }
  createFolder(request.outdir);
}

SimulatedUavSummary summaryOf(const PlannedUav& uav) {
  return {uav.options.name, uav.photos.size(),           uav.gnss.fixes.size(),
          uav.strips,       uav.options.flight.height_m, uav.gsd_m()};
}

}  // namespace

SimulationSummary simulate(Config& config, const SimulationRequest& request) {
  const double start = wallSeconds();
  const SimulationSetup setup = loadSimulation(config);
  const Eigen::AlignedBox2d area = areaOf(setup);
  const LocalFrame world(setup.origin);
  const int seed = setup.scene.seed > 0 ? setup.scene.seed : setup.simulation.seed;
  const Scene scene(setup.scene, area, streamSeed(static_cast<std::uint64_t>(seed), "scene"));
  const std::vector<PlannedUav> uavs = planCluster(setup, scene, world);

  clear(request, setup);
  const fs::path truth = request.outdir / "truth";
  writeTruthFiles(truth, setup, world, area, uavs);
  writeFileAtomically(truth / "simulation.ini", config.effectiveText());
  SimulationSummary summary;
  std::size_t photos = 0;
  for (const PlannedUav& uav : uavs) {
    writeRawlog(uav, request.outdir);
    summary.uavs.push_back(summaryOf(uav));
    photos += uav.photos.size();
  }
  {
    Progress progress("photos", photos);
    for (const PlannedUav& uav : uavs)
      for (const PlannedPhoto& photo : uav.photos) {
        summary.render_wall_s += writePhoto(uav, photo, scene, setup.photo, request.outdir);
        if (setup.simulation.depth_megapixels > 0)
          writeDepth(uav, photo, scene, setup.photo, setup.simulation.depth_megapixels, truth);
        progress.advance(photo.name);
      }
  }
  if (setup.simulation.reference_spacing_m > 0) {
    logInfo("reference surface");
    writeReferenceSurface(scene, uavs, world, setup.simulation.reference_spacing_m, truth);
  }
  writeRunConfig(setup, uavs, request.outdir / "config.ini");
  summary.wall_s = wallSeconds() - start;
  return summary;
}

}  // namespace cf
