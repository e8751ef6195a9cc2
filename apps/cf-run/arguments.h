// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cf/pipeline/agent_run.h"
#include "cf/pipeline/flight_run.h"

namespace cf {

struct RunArguments {
  std::string config;
  std::vector<std::string> overrides;  ///< "section.key=value"
  FlightRunRequest request;
  std::optional<AgentRequest> agent;  ///< only that instead
};

/// Parses the command line; nothing after --help and --version. Throws UsageError.
std::optional<RunArguments> runArguments(int argc, char** argv);

/// What the run reached, on stdout.
void printSummary(const AgentSummary& agent);
void printSummary(const RunRecord& run, const std::filesystem::path& outdir);

}  // namespace cf
