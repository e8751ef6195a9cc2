// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace cf {

/// One line each on stderr; thread-safe. Format with fmt::format at the call.
void logInfo(const std::string& line);
void logWarning(const std::string& line);

/// Lines below warnings are dropped when quiet (tests, benchmarks).
void setLogQuiet(bool quiet);

}  // namespace cf
