// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace cf {

/// Parses the command line and renders one picture; returns the exit status.
int snapshotCommand(int argc, char** argv);

}  // namespace cf
