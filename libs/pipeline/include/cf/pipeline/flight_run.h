// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "cf/deliver/run_record.h"
#include "cf/pipeline/run_options.h"

namespace cf {

class Config;

/// Plays the rawlogs of a configuration through all stages and writes the output folder.
/// The body of cf-run, so that tests can run it too.
struct FlightRunRequest {
  std::filesystem::path outdir;
  bool overwrite = false;  ///< of an earlier result
  std::string version;
  bool resume = false;  ///< go on with what an interrupted run has left
  /// Folder in which agents (agent_run.h) write what crosses the seam: this is the central node
  /// alone. Empty: the UAVs' part too is done here.
  std::filesystem::path seam = {};
};

/// Below the output folder: what only lives as long as the run. While it is there, the run has not
/// come to its end, and can be resumed.
std::filesystem::path workFolder(const std::filesystem::path& outdir);

/// An earlier run came to its end there: nothing is left to resume.
bool isFinished(const std::filesystem::path& outdir);

/// Throws UsageError for a bad configuration, RunError for what cannot be read or written. Damaged
/// photos are skipped, counted and reported. Returns what was delivered.
RunRecord runFlight(Config& config, const FlightRunRequest& request);

}  // namespace cf
