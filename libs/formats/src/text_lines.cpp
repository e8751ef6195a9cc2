// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/text_lines.h"

#include <fstream>

#include "cf/base/error.h"
#include "cf/base/text.h"

namespace cf {

std::vector<TextLine> readTextLines(const std::filesystem::path& file) {
  std::error_code ignored;
  std::ifstream in;
  if (std::filesystem::is_regular_file(file, ignored)) in.open(file);
  if (!in.is_open()) throw UsageError(file.string() + " cannot be read: is it there?");
  std::vector<TextLine> lines;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    constexpr const char* kByteOrderMark = "\xEF\xBB\xBF";
    if (number == 1 && line.rfind(kByteOrderMark, 0) == 0) line.erase(0, 3);
    line = trimmed(line.substr(0, line.find('#')));
    if (!line.empty()) lines.push_back({number, line});
  }
  return lines;
}

}  // namespace cf
