// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cf/base/error.h>
#include <cf/config/config.h>
#include <cf/geodesy/local_frame.h>
#include <cf/pipeline/flight_run.h>

#include <cstdio>

/// Prints the UTM zone of a place, and why a flight without rawlogs cannot be mapped: argv[1] is
/// its configuration.
int main(int argc, char** argv) {
  if (argc != 2) return 2;
  std::printf("%s\n", cf::LocalFrame(46.95, 7.44, 540).utmZone().c_str());
  try {
    auto config = cf::Config::fromFile(argv[1]);
    cf::runFlight(config, {"never", false, "0"});
  } catch (const cf::UsageError& error) {
    std::printf("%s\n", error.what());
    return 0;
  }
  return 1;
}
