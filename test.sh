#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 ClusterFusion authors
# SPDX-License-Identifier: BSD-3-Clause
#
# ./test.sh [ctest options]   installs what is missing, builds, runs the tests.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
source scripts/prepare.sh

installPackages packages.txt packages-test.txt
build all
jobs=$(nproc)
say "runs the tests"
ctest --test-dir build --output-on-failure --parallel $((jobs < 2 ? jobs : 2)) "$@"
