// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "ini_file.h"

#include <fmt/format.h>
#include <mrpt/config/CConfigFile.h>

#include <algorithm>
#include <cctype>
#include <fstream>

#include "cf/base/error.h"

namespace cf {
namespace {

bool isBlank(char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; }

/// Blanks and the end of a line of Windows are none.
bool isControl(char c) { return std::iscntrl(static_cast<unsigned char>(c)) != 0 && !isBlank(c); }

/// The lines of an ini turned into sections; every line must have a meaning.
class IniScanner {
 public:
  explicit IniScanner(const std::filesystem::path& file) : file_(file) {}

  void takeLine(const std::string& raw) {
    ++line_;
    if (std::any_of(raw.begin(), raw.end(), isControl))
      fail("holds a control character; is this a text file?");
    const std::string line = withoutComment(raw);
    if (line.empty()) return;
    if (line.front() == '[')
      takeSection(line);
    else
      takeEntry(line);
  }

  std::vector<IniSection> sections() && { return std::move(sections_); }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw UsageError(fmt::format("{}:{}: {}", file_.string(), line_, what));
  }

  void takeSection(const std::string& line) {
    const std::string name = trimmed(line.substr(1, line.size() - 2));
    if (line.size() < 3 || line.back() != ']' || name.empty())
      fail(fmt::format("'{}' is not a section; write [name]", line));
    for (const auto& earlier : sections_)
      if (sameName(earlier.name, name))
        fail(fmt::format("section [{}] was begun before, in line {}; put its keys there", name,
                         earlier.line));
    sections_.push_back({name, line_, {}});
  }

  void takeEntry(const std::string& line) {
    const std::size_t equals = line.find('=');
    if (equals == std::string::npos || equals == 0)
      fail(fmt::format("'{}' is neither a [section], a 'key = value' nor a comment", line));
    const std::string key = trimmed(line.substr(0, equals));
    if (sections_.empty()) fail(fmt::format("key '{}' stands before the first [section]", key));
    for (const auto& earlier : sections_.back().entries)
      if (sameName(earlier.key, key))
        fail(fmt::format("[{}] key '{}' was given before, in line {}", sections_.back().name, key,
                         earlier.line));
    sections_.back().entries.push_back({key, {}, line_});
  }

  std::filesystem::path file_;
  int line_ = 0;
  std::vector<IniSection> sections_;
};

}  // namespace

std::string withoutComment(const std::string& text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool mark = text[i] == '#' || text[i] == ';' || text.compare(i, 2, "//") == 0;
    if (mark && (i == 0 || isBlank(text[i - 1]))) return trimmed(text.substr(0, i));
  }
  return trimmed(text);
}

bool sameName(const std::string& a, const std::string& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) {
    return std::tolower(static_cast<unsigned char>(x)) ==
           std::tolower(static_cast<unsigned char>(y));
  });
}

std::vector<IniSection> readIniFile(const std::filesystem::path& file) {
  std::error_code ignored;
  std::ifstream in;
  if (std::filesystem::is_regular_file(file, ignored)) in.open(file);
  if (!in.is_open())
    throw UsageError(fmt::format("{}: no such configuration file, or not readable", file.string()));
  IniScanner scanner(file);
  for (std::string line; std::getline(in, line);) {
    constexpr const char* kByteOrderMark = "\xEF\xBB\xBF";
    if (line.compare(0, 3, kByteOrderMark) == 0) line.erase(0, 3);
    scanner.takeLine(line);
  }
  auto sections = std::move(scanner).sections();

  try {
    const mrpt::config::CConfigFile values(file.string());
    for (auto& section : sections)
      for (auto& entry : section.entries)
        entry.value = withoutComment(values.read_string(section.name, entry.key, "", true));
  } catch (const std::exception&) {  // where it sees another file than our check has seen
    throw UsageError(fmt::format("{}: cannot be read as an ini: write it anew", file.string()));
  }
  return sections;
}

}  // namespace cf
