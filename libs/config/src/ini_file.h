// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "cf/base/text.h"

namespace cf {

struct IniEntry {
  std::string key, value;
  int line = 0;
};
struct IniSection {
  std::string name;
  int line = 0;
  std::vector<IniEntry> entries;
};

/// Reads an ini through MRPT's CConfigFile after a strict check of each line, which CConfigFile
/// does not do: it drops lines that it does not understand and merges sections and keys given
/// twice. Throws UsageError "FILE:LINE: …".
std::vector<IniSection> readIniFile(const std::filesystem::path& file);

/// `text` up to a comment: '#', ';' or "//" at its start or after a blank; outer blanks removed.
std::string withoutComment(const std::string& text);

/// Equality as CConfigFile has it for sections and keys: ASCII case ignored.
bool sameName(const std::string& a, const std::string& b);

}  // namespace cf
