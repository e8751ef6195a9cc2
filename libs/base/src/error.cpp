// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/base/error.h"

#include <cstdio>
#include <exception>

#include "cf/base/text.h"

namespace cf {
namespace {

/// Other libraries' messages may have several lines.
std::string oneLine(const char* text) {
  std::string line;
  for (const std::string& word : wordsOf(text)) line += (line.empty() ? "" : " ") + word;
  return line;
}

}  // namespace

int exitStatusOf(const char* app, int (*body)(int, char**), int argc, char** argv) {
  try {
    return body(argc, argv);
  } catch (const UsageError& e) {
    std::fprintf(stderr, "%s: %s\n", app, printable(e.what()).c_str());
    return 2;
  } catch (const RunError& e) {
    std::fprintf(stderr, "%s: %s\n", app, printable(e.what()).c_str());
    return 1;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s: %s\n", app, printable(oneLine(e.what())).c_str());
    return 1;
  }
}

}  // namespace cf
