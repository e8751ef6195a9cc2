// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>

namespace cf {

/// An error of the run: input or output that cannot be read or written. Exit status 1.
/// The message is one line that names the thing, what was wrong and what to do.
class RunError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// An error of the command line or configuration. Exit status 2.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Runs `body` and turns exceptions into one line on stderr and the contract's exit status:
/// 0 done, 1 error in the run, 2 usage or configuration.
int exitStatusOf(const char* app, int (*body)(int, char**), int argc, char** argv);

}  // namespace cf
