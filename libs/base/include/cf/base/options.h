// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <string>
#include <vector>

namespace cf {

/// Closed interval of values that an option may have.
struct Range {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
};

/// Every stage owns an options struct with `void visit(OptionVisitor&)` that names each field once:
/// key, value, range, one line of help with the unit. From this come the strict loading of an ini
/// section, validation, the effective configuration and docs/config.md (libs/config).
class OptionVisitor {
 public:
  virtual ~OptionVisitor() = default;
  virtual void number(const char* key, double& value, Range range, const char* help) = 0;
  virtual void integer(const char* key, int& value, Range range, const char* help) = 0;
  virtual void flag(const char* key, bool& value, const char* help) = 0;
  virtual void text(const char* key, std::string& value, const char* help) = 0;
  /// A file, relative ones counted from the configuration's folder.
  virtual void path(const char* key, std::string& value, const char* help) {
    text(key, value, help);
  }
  virtual void choice(const char* key, std::string& value, const std::vector<std::string>& allowed,
                      const char* help) = 0;
};

}  // namespace cf
