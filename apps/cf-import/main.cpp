// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <csignal>

#include "arguments.h"
#include "cf/base/error.h"
#include "cf/base/log.h"

namespace {

volatile std::sig_atomic_t stopped = 0;

int run(int argc, char** argv) {
  auto options = cf::importArguments(argc, argv);
  if (!options) return 0;  // --help, --version
  if (options->follow_s > 0) {
    options->stop = [] { return stopped != 0; };
    for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { stopped = 1; });
  }
  const cf::ImportSummary summary = cf::importFlights(*options);
  for (const std::string& warning : summary.warnings) cf::logWarning(warning);
  cf::printSummary(summary);
  return 0;
}

}  // namespace

int main(int argc, char** argv) { return cf::exitStatusOf("cf-import", run, argc, argv); }
