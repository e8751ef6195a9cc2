// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cf/simulate/simulation.h"

namespace cf {

struct SimulateArguments {
  std::string config;
  std::vector<std::string> overrides;  ///< "section.key=value"
  SimulationRequest request;
};

/// Parses the command line; nothing after --help and --version. Throws UsageError.
std::optional<SimulateArguments> simulateArguments(int argc, char** argv);

/// What was flown, on stdout.
void printSummary(const SimulationSummary& summary, const std::filesystem::path& outdir);

}  // namespace cf
