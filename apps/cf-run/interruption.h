// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "arguments.h"

namespace cf {

/// From now on Ctrl-C (and SIGTERM) ends the program with a line that says what is kept and how to
/// go on, and with exit status 130. Nothing needs to be put in order for that: files appear whole.
void sayWhatAnInterruptionKeeps(const RunArguments& arguments);

}  // namespace cf
