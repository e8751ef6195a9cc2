// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace cf {

struct TextLine {
  int number = 0;  ///< in the file, from 1
  std::string text;
};

/// The lines of a text that people write, without what follows a '#', the white space at both
/// ends, and a byte order mark; empty ones are left out. Throws UsageError naming the file if it
/// cannot be read.
std::vector<TextLine> readTextLines(const std::filesystem::path& file);

}  // namespace cf
