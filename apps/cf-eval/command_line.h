// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace cf {

/// Parses `cf-eval trajectory|cloud|run|gcp|change …`, evaluates, prints JSON (or a table) on stdout.
int runEval(int argc, char** argv);

}  // namespace cf
