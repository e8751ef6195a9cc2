// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "arguments.h"
#include "cf/base/error.h"
#include "cf/base/log.h"

namespace {

int run(int argc, char** argv) {
  const auto options = cf::importArguments(argc, argv);
  if (!options) return 0;  // --help, --version
  const cf::ImportSummary summary = cf::importFlights(*options);
  for (const std::string& warning : summary.warnings) cf::logWarning(warning);
  cf::printSummary(summary);
  return 0;
}

}  // namespace

int main(int argc, char** argv) { return cf::exitStatusOf("cf-import", run, argc, argv); }
