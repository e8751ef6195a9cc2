// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "cf/import/import.h"

namespace cf {

/// Parses the command line; nothing after --help and --version. Throws UsageError.
std::optional<ImportOptions> importArguments(int argc, char** argv);

/// What became of the photos, on stdout.
void printSummary(const ImportSummary& summary);

}  // namespace cf
