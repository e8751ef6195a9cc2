// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include "arguments.h"
#include "cf/base/error.h"
#include "cf/config/config.h"
#include "interruption.h"

namespace {

int run(int argc, char** argv) {
  const auto arguments = cf::runArguments(argc, argv);
  if (!arguments) return 0;  // --help, --version
  cf::sayWhatAnInterruptionKeeps(*arguments);
  cf::Config config = cf::Config::fromFile(arguments->config);
  for (const std::string& assignment : arguments->overrides) config.override(assignment);
  if (arguments->agent) {
    cf::printSummary(cf::runAgent(config, *arguments->agent));
    return 0;
  }
  if (arguments->request.resume && cf::isFinished(arguments->request.outdir)) {
    fmt::print("{} holds a finished result: nothing to resume\n",
               arguments->request.outdir.string());
    return 0;
  }
  cf::printSummary(cf::runFlight(config, arguments->request), arguments->request.outdir);
  return 0;
}

}  // namespace

int main(int argc, char** argv) { return cf::exitStatusOf("cf-run", run, argc, argv); }
