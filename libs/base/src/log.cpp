// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/base/log.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

namespace cf {
namespace {

spdlog::logger& logger() {
  static const auto instance = [] {
    auto made = spdlog::stderr_logger_mt("cf");
    // On a terminal a line takes the place of progress that is shown there.
    made->set_pattern(isatty(STDERR_FILENO) != 0 ? "\r\033[J%v" : "%v");
    return made;
  }();
  return *instance;
}

}  // namespace

void logInfo(const std::string& line) { logger().info("{}", line); }
void logWarning(const std::string& line) { logger().warn("warning: {}", line); }
void setLogQuiet(bool quiet) {
  logger().set_level(quiet ? spdlog::level::warn : spdlog::level::info);
}

}  // namespace cf
