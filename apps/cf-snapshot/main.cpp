// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/base/error.h"
#include "snapshot_command.h"

int main(int argc, char** argv) {
  return cf::exitStatusOf("cf-snapshot", cf::snapshotCommand, argc, argv);
}
