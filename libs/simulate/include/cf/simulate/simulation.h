// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace cf {

class Config;

struct SimulationRequest {
  std::filesystem::path outdir;
  bool overwrite = false;  ///< what is there: truth/, and the UAVs' rawlogs and photos
};

struct SimulatedUavSummary {
  std::string name;
  std::size_t photos = 0, fixes = 0, strips = 0;
  double height_m = 0;
  double gsd_m = 0;  ///< ground size of a pixel
};

struct SimulationSummary {
  std::vector<SimulatedUavSummary> uavs;
  double wall_s = 0;         ///< all of it
  double render_wall_s = 0;  ///< taking the photos alone
};

/// Simulates the flights of a configuration (docs/simulate.md): writes what cf-import would write
/// of them, and in truth/ what they were. The body of cf-simulate. The same configuration gives the
/// same bytes. Throws UsageError for a bad configuration, RunError for what cannot be written.
SimulationSummary simulate(Config& config, const SimulationRequest& request);

}  // namespace cf
