// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/pipeline/agent_run.h"

#include <fmt/format.h>

#include <algorithm>

#include "cf/base/error.h"
#include "cf/base/log.h"
#include "cf/config/config.h"
#include "chain_steps.h"
#include "flight_progress.h"
#include "memory_plan.h"
#include "thread_limit.h"
#include "world.h"

namespace cf {
namespace fs = std::filesystem;
namespace {

std::uint16_t placeOf(const std::string& name, const RunOptions& options,
                      const std::string& config) {
  for (std::size_t u = 0; u < options.uavs.size(); ++u)
    if (options.uavs[u].name == name) return static_cast<std::uint16_t>(u);
  throw UsageError(fmt::format("{} has no section [uav.{}]", config, name));
}

/// An agent sees no other UAV: what the whole cluster must share has to be known beforehand.
void demandOrigin(std::uint16_t uav, const RunOptions& options) {
  if (options.world.origin.empty() && uav != centralUav(options))
    throw UsageError(fmt::format(
        "the agent of {} does not know the world's origin, the first fix of {}: give [world] "
        "origin = LAT, LON, H to all agents and the central node",
        options.uavs[uav].name, options.cluster.center));
}

World worldOf(const UavInput& input, const RunOptions& options) {
  const auto first = input.firstFix();
  if (first) demandOrigin(input.uav(), options);
  std::vector<std::optional<GnssFix>> first_fixes(options.uavs.size());
  first_fixes[input.uav()] = first;
  return placeWorld(options, first_fixes);
}

}  // namespace

AgentSummary runAgent(Config& config, const AgentRequest& request) {
  const RunOptions options = loadRunOptions(config);
  const ThreadLimit limit(options);
  const std::uint16_t uav = placeOf(request.uav, options, config.file().string());
  const fs::path file = request.seam / (request.uav + ".seam");
  if (fs::exists(file) && !request.overwrite && !request.resume)
    throw UsageError(file.string() +
                     " is there already; give --resume to go on with it or -w to begin it anew");
  std::vector<UavInput> inputs;
  inputs.emplace_back(config, options, uav);
  PhotoFeed feed(std::move(inputs), options.playback);
  if (feed.follows()) {
    demandOrigin(uav, options);
    feed.awaitStart(0);
  }
  const UavInput& input = feed.inputs().front();
  for (const std::string& warning : input.warnings()) logWarning(input.name() + ": " + warning);
  const World world = worldOf(input, options);
  std::error_code error;
  fs::create_directories(request.seam, error);
  if (error) throw RunError(request.seam.string() + " cannot be made: " + error.message());
  FlightSize size;
  for (const UavInput::Waiting& waiting : input.photos()) size.add(waiting.photo);
  const MemoryPlan memory = planMemory(options, size);
  StageTimes times;
  ChainSteps source(std::move(feed), options, world.frame, times);
  source.writeTo(0, request.resume ? SeamWriter::goOn(file) : SeamWriter(file));
  std::size_t photos = 0;
  FlightProgress progress(source, options.playback.inRealTime());
  tbb::parallel_pipeline(
      memory.steps_in_flight,
      source.steps() & tbb::make_filter<StepSource::Step, void>(tbb::filter_mode::serial_in_order,
                                                                [&](const StepSource::Step& step) {
                                                                  progress.advance(*step);
                                                                  if (step->photo) ++photos;
                                                                }));
  return {photos, source.bytes(), file};
}

}  // namespace cf
