// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/base/error.h"

#include <cctype>
#include <cstdio>
#include <exception>
#include <sstream>

namespace cf {
namespace {

/// Names of files and what they hold are shown as they are, but for control characters.
std::string printable(std::string text) {
  for (char& c : text)
    if (std::iscntrl(static_cast<unsigned char>(c)) != 0) c = '?';
  return text;
}

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
