// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/pipeline/run_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "cf/base/error.h"
#include "cf/config/config.h"

namespace cf {

void WorldOptions::visit(OptionVisitor& v) {
  v.text("origin", origin,
         "LAT, LON, H of the map's ENU frame; empty: the central UAV's first fix");
}

void ClusterOptions::visit(OptionVisitor& v) {
  v.text("center", center, "name of the central UAV; empty: the first of the configuration");
}

void UavOptions::visit(OptionVisitor& v) {
  v.path("rawlog", rawlog, "MRPT rawlog, relative to this file");
  v.text("image_label", image_label, "sensor label of the camera, where there are several");
  v.text("gnss_label", gnss_label, "sensor label of the receiver, where there are several");
  v.text("sigma", sigma, "H,V: standard deviation of the fixes [m], instead of the rawlog's");
  v.path("camera", camera, "ini with a calibration, instead of the rawlog's");
}

void PlaybackOptions::visit(OptionVisitor& v) {
  v.number("rate", rate, {0, 1000}, "times real time; 0 = as fast as possible");
  v.number("max_gap_s", max_gap_s, {0.01, 86400},
           "at a rate: a longer pause between photos is cut to this [s]");
  v.number("follow_s", follow_s, {0, 86400},
           "rawlogs that are still being written: the flight has ended when none has grown for so "
           "long [s]; 0 = they are complete");
  v.number("hold_up_s", hold_up_s, {0, 86400},
           "following: others wait no longer than this [s] for a UAV that may have earlier photos");
  v.number("max_lag_s", max_lag_s, {0.1, 86400},
           "where playback in real time is further behind [s], the live map leaves photos out");
  v.number("wait_s", wait_s, {0.1, 86400},
           "--role central: an agent that has written nothing for so long [s] has ended");
}

void ViewOptions::visit(OptionVisitor& v) {
  v.flag("snapshots", snapshots, "render pictures at the end of the run");
  v.number("live_every_s", live_every_s, {0, 86400},
           "seconds between pictures of the growing map (live/*.png); 0 = none");
  v.number("live_megapixels", live_megapixels, {0.05, 100},
           "size matched for the live map [MP]; the final map has [densify] megapixels");
  v.text("size", size, "WIDTHxHEIGHT of the pictures [px]");
}

void SystemOptions::visit(OptionVisitor& v) {
  v.integer("threads", threads, {0, 1024}, "0 = one for each core");
  v.integer("max_memory_mb", max_memory_mb, {0, 1 << 24},
            "memory that the run may take [MB]: it gets slower rather than larger, with the same "
            "result; 0 = three quarters of the machine's");
}

namespace {

void checkUav(const UavOptions& uav, const std::string& where) {
  if (uav.rawlog.empty()) throw UsageError(where + "needs rawlog = FILE");
  if (uav.name.empty() || uav.name.front() == '.' || uav.name.find('/') != std::string::npos)
    throw UsageError(where +
                     "names a UAV; the name becomes a file name: no '/' in it, no '.' before it");
  if (uav.sigma.empty()) return;
  const auto sigma = parseNumbers(uav.sigma, 2, where + "sigma");
  if (!(sigma[0] > 0) || !(sigma[1] > 0))
    throw UsageError(where + "sigma = " + uav.sigma + " should be two numbers of metres above 0");
}

}  // namespace

RunOptions loadRunOptions(Config& config) {
  RunOptions options;
  config.load("world", options.world);
  config.load("cluster", options.cluster);
  for (const std::string& section : config.sections("uav.")) {
    UavOptions uav;
    uav.name = section.substr(4);
    config.load(section, uav);
    options.uavs.push_back(uav);
  }
  config.load("playback", options.playback);
  config.load("odometry", options.odometry);
  config.load("georeference", options.georeference);
  config.load("align", options.align);
  config.load("gcp", options.gcp);
  config.load("densify", options.densify);
  config.load("fuse", options.fuse);
  config.load("octomap", options.octomap);
  config.load("deliver", options.deliver);
  config.load("view", options.view);
  config.load("system", options.system);
  config.rejectUnknown();
  if (options.playback.rate > 0 && options.playback.follow_s > 0)
    throw UsageError(config.file().string() +
                     ": [playback] rate replays a flight, follow_s watches one: give only one");
  const std::string file = config.file().string();
  for (const UavOptions& uav : options.uavs) checkUav(uav, file + ": [uav." + uav.name + "] ");
  if (options.uavs.empty())
    throw UsageError(file + ": no [uav.NAME] section: nothing to play (cf-import writes them)");
  if (options.cluster.center.empty()) options.cluster.center = options.uavs.front().name;
  if (std::none_of(options.uavs.begin(), options.uavs.end(),
                   [&](const UavOptions& u) { return u.name == options.cluster.center; }))
    throw UsageError(file + ": [cluster] center = " + options.cluster.center +
                     " is none of the [uav.NAME] sections");
  if (!options.world.origin.empty()) {
    const auto p = parseNumbers(options.world.origin, 3, file + ": [world] origin");
    if (std::abs(p[0]) > 90 || std::abs(p[1]) > 360)
      throw UsageError(file + ": [world] origin is LAT, LON, H in degrees and metres");
  }
  parseImageSize(options.view.size);
  return options;
}

std::vector<double> parseNumbers(const std::string& text, std::size_t count,
                                 const std::string& what) {
  std::vector<double> numbers;
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  double value = 0;
  while (in >> value) {
    numbers.push_back(value);
    in >> std::ws;
    if (in.peek() == ',') in.get();
  }
  if (!in.eof() || numbers.size() != count)
    throw UsageError(
        fmt::format("{} = '{}' should be {} numbers separated by commas", what, text, count));
  return numbers;
}

}  // namespace cf
