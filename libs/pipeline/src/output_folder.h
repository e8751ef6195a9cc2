// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>

#include "cf/pipeline/flight_run.h"
#include "cf/pipeline/run_options.h"

namespace cf {

class Config;

/// Throws UsageError where there is a result that nobody asked to replace, an interrupted run that
/// was neither to be resumed nor overwritten, or one of other settings or recordings.
void checkOutput(const FlightRunRequest& request, const Config& config, const RunOptions& options);

/// After that: makes the output folder ready: empty of earlier results if they may be overwritten,
/// with config.effective.ini, and with the work folder; that of an interrupted run stays as it is
/// if it is to be resumed. Throws RunError where it cannot be written or the disk is too full for
/// `photos`.
void prepareOutput(const FlightRunRequest& request, const Config& config, const RunOptions& options,
                   std::size_t photos);

}  // namespace cf
