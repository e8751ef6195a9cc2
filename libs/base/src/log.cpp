// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/base/log.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

namespace cf {
namespace {

spdlog::logger& logger() {
  static const auto instance = [] {
    auto made = spdlog::stderr_logger_mt("cf");
    made->set_pattern("%v");
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
