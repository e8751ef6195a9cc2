// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "cf/base/error.h"

namespace cf {

/// Reads the command line into what `app` was bound to. False where that was --help or --version,
/// which is printed then; throws UsageError with one line for everything else.
inline bool parseArguments(CLI::App& app, int argc, char** argv) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help) {
    app.exit(help);
    return false;
  } catch (const CLI::ParseError& e) {
    throw UsageError(std::string(e.what()) + " (see " + app.get_name() + " --help)");
  }
  return true;
}

}  // namespace cf
