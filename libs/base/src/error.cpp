// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/base/error.h"

#include <cstdio>
#include <exception>
#include <sstream>

namespace cf {
namespace {

/// Other libraries' messages may have several lines.
std::string oneLine(const char* text) {
  std::istringstream words(text);
  std::string line, word;
  while (words >> word) line += (line.empty() ? "" : " ") + word;
  return line;
}

}  // namespace

int exitStatusOf(const char* app, int (*body)(int, char**), int argc, char** argv) {
  try {
    return body(argc, argv);
  } catch (const UsageError& e) {
    std::fprintf(stderr, "%s: %s\n", app, e.what());
    return 2;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s: %s\n", app, oneLine(e.what()).c_str());
    return 1;
  }
}

}  // namespace cf
