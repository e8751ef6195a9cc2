// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/base/error.h"
#include "command_line.h"

int main(int argc, char** argv) { return cf::exitStatusOf("cf-eval", cf::runEval, argc, argv); }
